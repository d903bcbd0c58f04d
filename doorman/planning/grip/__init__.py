"""Plans of a vehicle whose tip holds on to the door: quasi-static, or with the full Lagrangian dynamics."""
