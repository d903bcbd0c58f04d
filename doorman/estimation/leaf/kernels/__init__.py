"""Kernels of the estimate at the leaf beside its bank."""
