"""Linear and quadratic programs along a horizon: sweeps, eliminations, active sets."""
