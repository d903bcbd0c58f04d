"""Collision: the analytic constraints of the planner, the FCL scene of the URDFs, and the audit of one by the other."""
