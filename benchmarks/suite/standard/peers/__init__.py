"""The solvers of the standard problems, one a file."""
