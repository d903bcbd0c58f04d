"""What is measured: one workload a file, each a function of the session that returns plain numbers."""
