"""Optimal control: problems with constraints and bounds, and solvers that hand out what may be used, or say why not."""

from __future__ import annotations

from typing import TYPE_CHECKING

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
from doorman.ocp.symbolic.terms import Constraint, Cost, Residual

__all__ = [
    "AugmentedLagrangian", "Bounds", "Cddp", "Constraint", "Cost", "Hybrid", "PlanStatus", "Problem", "PythonModel",
    "QuadraticCost", "Residual", "Solution", "Solver", "SolverOptions", "SymbolicModel", "runge_kutta",
]  # fmt: skip

if TYPE_CHECKING:
    from doorman.ocp.symbolic.model import SymbolicModel
else:

    def __getattr__(name: str) -> object:
        """`SymbolicModel` brings in CasADi, when it is first asked for."""
        if name != "SymbolicModel":
            raise AttributeError(f"module '{__name__}' has no attribute '{name}'", name=name)
        from doorman.ocp.symbolic.model import SymbolicModel

        globals()[name] = SymbolicModel
        return SymbolicModel
