"""Optimal control: problems with constraints and bounds, and solvers that hand out what may be used, or say why not."""

from doorman.ocp import defaults as defaults
from doorman.ocp.al import AugmentedLagrangian
from doorman.ocp.cddp import Cddp
from doorman.ocp.costs import QuadraticCost
from doorman.ocp.hybrid import Hybrid
from doorman.ocp.options import SolverOptions
from doorman.ocp.problem import Bounds, Problem
from doorman.ocp.python_functions import runge_kutta
from doorman.ocp.python_model import PythonModel
from doorman.ocp.solution import PlanStatus, Solution
from doorman.ocp.solver import Solver

__all__ = [
    "AugmentedLagrangian", "Bounds", "Cddp", "Hybrid", "PlanStatus", "Problem", "PythonModel", "QuadraticCost", "Solution",
    "Solver", "SolverOptions", "runge_kutta",
]  # fmt: skip
