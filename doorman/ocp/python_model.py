"""Models of plain Python functions, for a first try: every solver solves them, at Python's speed.

A call takes some ten microseconds besides the user's own code, and derivatives take 2 (nx + nu) calls of a function at every
node of every iteration: hundreds of times what compiled kernels take. Solvers are compiled for the sizes of a problem, not for
its functions: once some sizes are in the cache on disk, other functions of these sizes begin at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from doorman.exceptions import SolverError
from doorman.ocp.kernels.python_functions import CheckedFunction, Function, Method, count
from doorman.ocp.kernels.python_table import PythonModelFunctions, PythonModelWithCost
from doorman.ocp.problem.costs import QuadraticCost
from doorman.ocp.problem.problem import Bounds, Problem

_OF_BOTH = "step", "input_constraints", "stage_cost"
"""Functions of a state and an input."""


@dataclass(frozen=True)
class PythonModel:
    """Dynamics, constraints and costs as Python functions of numpy arrays; `problem` makes a problem of them.

    Every function gets copies: a state, shape (nx,), and where it has two arguments an input, shape (nu,). What a function
    raises comes out of `Solver.solve` with its own traceback.
    """

    step: Function
    """x⁺ of x and u: an array or a list of nx numbers. `runge_kutta` makes one of a continuous derivative."""
    constraints: Function | None = None
    """h of x, to be ≤ 0 at every state after the first: one number or several."""
    input_constraints: Function | None = None
    """g of x and u, to be ≤ 0 at every node but the last."""
    end_constraints: Function | None = None
    """h_N of x, to be ≤ 0 at the last state."""
    stage_cost: Function | None = None
    """Cost of a node on top of the quadratic one, of x and u: a number, already times Δt."""
    end_cost: Function | None = None
    """Cost of the last state on top of the quadratic one, of x."""
    derivatives: Method = "differences"
    """Central differences, or complex steps: exact, for functions that take complex numbers and know no abs, no comparisons."""

    def __post_init__(self) -> None:
        if self.derivatives not in ("differences", "complex step"):
            raise SolverError(
                "unknown", field="derivatives", given=self.derivatives, allowed="'differences' or 'complex step'"
            )

    def problem(
        self,
        cost: QuadraticCost,
        horizon: int,
        time_step: float,
        bounds: Bounds | None = None,
        constraint_names: Sequence[str] = (),
        equalities: Sequence[bool] = (),
    ) -> Problem:
        """Problem of these functions, which are called at the goal.

        Args:
            cost: Quadratic cost; its goals tell the numbers of states and inputs.
            horizon: N, number of steps.
            time_step: Δt [s].
            bounds: Of states and inputs.
            constraint_names: Of the rows of h, g and h_N.
            equalities: Which of these rows are to be 0 instead of ≤ 0.

        Returns:
            The problem.

        Raises:
            DimensionError: if a function returns something else than the numbers that it has to, or sizes do not fit.
            SolverError: if a function is not one of complex numbers, though complex steps need one.
        """
        state, both = (cost.state_goal,), (cost.state_goal, cost.input_goal)
        sizes = {"step": len(cost.state_goal), "stage_cost": 1, "end_cost": 1}
        for name in ("constraints", "input_constraints", "end_constraints"):
            function = getattr(self, name)
            sizes[name] = 0 if function is None else count(function, name, *(both if name in _OF_BOTH else state))
        checked = {
            name: CheckedFunction(getattr(self, name), name, size, self.derivatives)
            for name, size in sizes.items()
            if getattr(self, name) is not None
        }
        for name, function in checked.items():
            function.check(*(both if name in _OF_BOTH else state))
        own_cost = "stage_cost" in checked or "end_cost" in checked
        return Problem(
            (PythonModelWithCost if own_cost else PythonModelFunctions)(checked),
            horizon=horizon, time_step=time_step, cost=cost, bounds=bounds or Bounds(), n_constraints=sizes["constraints"],
            n_input_constraints=sizes["input_constraints"], n_end_constraints=sizes["end_constraints"],
            constraint_names=tuple(constraint_names), equalities=tuple(equalities),
        )  # fmt: skip
