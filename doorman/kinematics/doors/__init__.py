"""Doors: how a leaf moves, and what a URDF says of it."""
