"""Vehicles: body, arm and rotors, from a URDF."""
