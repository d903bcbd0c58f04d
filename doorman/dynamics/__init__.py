"""Dynamics of vehicle and door together: the quasi-static model of the planner and the full Lagrangian one."""
