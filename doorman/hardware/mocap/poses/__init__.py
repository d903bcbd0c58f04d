"""Poses: measurements into poses of the body in the world that can be believed, with velocities."""
