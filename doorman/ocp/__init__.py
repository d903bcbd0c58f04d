"""Optimal control: problems with constraints and bounds, and solvers that hand out what may be used, or say why not.

A name brings in its module at its first use: `SymbolicModel` alone brings in CasADi.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from doorman.lazy_names import lazy_names

if TYPE_CHECKING:  # the types of the names below; no layer hides an import here
    from doorman.ocp.kernels import functions as functions
    from doorman.ocp.kernels.python_functions import runge_kutta
    from doorman.ocp.problem.costs import QuadraticCost
    from doorman.ocp.problem.problem import Bounds, FreeTime, Problem
    from doorman.ocp.problem.terms import Constraint, Cost, Residual
    from doorman.ocp.python_model import PythonModel
    from doorman.ocp.solvers.cddp import Cddp
    from doorman.ocp.solvers.hybrid import Hybrid
    from doorman.ocp.solvers.options import SolverOptions
    from doorman.ocp.solvers.solution import PlanStatus, Solution
    from doorman.ocp.solvers.solver import Solver
    from doorman.ocp.solvers.telling import Iterate
    from doorman.ocp.symbolic_model import SymbolicModel

__all__ = [
    "Bounds", "Cddp", "Constraint", "Cost", "FreeTime", "Hybrid", "Iterate", "PlanStatus", "Problem",
    "PythonModel", "QuadraticCost", "Residual", "Solution", "Solver", "SolverOptions", "SymbolicModel", "runge_kutta",
]  # fmt: skip

_MODULES = {
    "Bounds": "problem.problem",
    "Cddp": "solvers.cddp",
    "Constraint": "problem.terms",
    "Cost": "problem.terms",
    "FreeTime": "problem.problem",
    "Hybrid": "solvers.hybrid",
    "Iterate": "solvers.telling",
    "PlanStatus": "solvers.solution",
    "Problem": "problem.problem",
    "PythonModel": "python_model",
    "QuadraticCost": "problem.costs",
    "Residual": "problem.terms",
    "Solution": "solvers.solution",
    "Solver": "solvers.solver",
    "SolverOptions": "solvers.options",
    "SymbolicModel": "symbolic_model",
    "functions": "kernels",
    "runge_kutta": "kernels.python_functions",
}

if not TYPE_CHECKING:  # a type checker would take any name for granted
    __getattr__, __dir__ = lazy_names(__name__, _MODULES)
