"""Optimal control: problems with constraints and bounds, and solvers that hand out what may be used, or say why not."""

from __future__ import annotations

from typing import TYPE_CHECKING

from doorman.ocp.kernels import default_curvature as default_curvature
from doorman.ocp.kernels import defaults as defaults
from doorman.ocp.kernels import functions
from doorman.ocp.kernels.python_functions import runge_kutta
from doorman.ocp.problem.costs import QuadraticCost
from doorman.ocp.problem.problem import Bounds, Problem
from doorman.ocp.problem.terms import Constraint, Cost, Residual
from doorman.ocp.python_model import PythonModel
from doorman.ocp.solvers.al import AugmentedLagrangian
from doorman.ocp.solvers.cddp import Cddp
from doorman.ocp.solvers.hybrid import Hybrid
from doorman.ocp.solvers.options import SolverOptions
from doorman.ocp.solvers.solution import PlanStatus, Solution
from doorman.ocp.solvers.solver import Solver
from doorman.ocp.solvers.telling import Iterate

__all__ = [
    "AugmentedLagrangian", "Bounds", "Cddp", "Constraint", "Cost", "Hybrid", "Iterate", "PlanStatus", "Problem", "PythonModel",
    "QuadraticCost", "Residual", "Solution", "Solver", "SolverOptions", "SymbolicModel", "functions", "runge_kutta",
]  # fmt: skip

if TYPE_CHECKING:
    from doorman.ocp.symbolic_model import SymbolicModel
else:

    def __getattr__(name: str) -> object:
        """`SymbolicModel` brings in CasADi, when it is first asked for."""
        if name != "SymbolicModel":
            raise AttributeError(f"module '{__name__}' has no attribute '{name}'", name=name)
        from doorman.ocp.symbolic_model import SymbolicModel

        globals()[name] = SymbolicModel
        return SymbolicModel
