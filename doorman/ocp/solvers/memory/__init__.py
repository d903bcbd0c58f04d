"""Memory of a solver: what kernels read and write."""
