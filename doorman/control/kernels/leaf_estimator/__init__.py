"""Kernels of `LeafEstimator`, whose docstring has the equations."""
