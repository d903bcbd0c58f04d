"""Expressions printed as modules of kernels."""
