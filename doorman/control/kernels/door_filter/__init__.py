"""Kernels of `DoorFilter`, whose docstring has the equations."""
