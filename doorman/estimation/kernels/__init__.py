"""Kernels of a bank of filters: any model, any measurements."""
