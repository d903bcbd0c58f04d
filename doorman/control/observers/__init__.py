"""Observers of forces and torques that the plan does not know."""
