"""The door tasks as optimal control problems, and the planner."""
