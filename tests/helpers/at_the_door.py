"""Overrides of the shipped task that begin it with the tip on the leaf."""

AT_THE_DOOR = {"mission.start": "contact", "simulation.door_damping": 0.0, "simulation.door_friction": 0.0}
"""The paper's task as the paper has it: from the touch on, with a hinge that is as the planner takes it."""
