"""Doors made from a door's URDF: of another size, elsewhere, or with another face."""
