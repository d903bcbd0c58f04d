"""Problems from CasADi expressions: printed as kernels, compiled once, kept on disk."""
