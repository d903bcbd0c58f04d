"""Figures of a flight: states, constraints and forces, the swing, the planner's time, and the layout of the paper."""
