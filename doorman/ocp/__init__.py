"""Optimal control: problems, costs, the CDDP solver, and the receding-horizon planner."""

from doorman.ocp.cddp import Cddp, CddpOptions
from doorman.ocp.costs import QuadraticCost
from doorman.ocp.planner import Plan, Planner
from doorman.ocp.problem import Problem
from doorman.ocp.solution import PlanStatus, Solution

__all__ = ["Cddp", "CddpOptions", "Plan", "PlanStatus", "Planner", "Problem", "QuadraticCost", "Solution"]
