"""A filter's expressions, printed as a module of kernels."""
