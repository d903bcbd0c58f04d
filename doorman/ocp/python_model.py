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
from doorman.ocp.kernels.python_kernels import Callback, kernels_of
from doorman.ocp.problem.costs import QuadraticCost
from doorman.ocp.problem.problem import Bounds, Problem


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
        rows = dict.fromkeys(("constraints", "input_constraints", "end_constraints"), 0)
        for name in rows:
            function = getattr(self, name)
            if function is not None:
                rows[name] = count(function, name, *(both if name == "input_constraints" else state))
        sizes = {"step": len(cost.state_goal), **rows, "stage_cost": 1, "end_cost": 1}
        checked = {
            name: CheckedFunction(getattr(self, name), name, size, self.derivatives)
            for name, size in sizes.items()
            if getattr(self, name) is not None
        }
        for name, function in checked.items():
            arguments = both if name in ("step", "input_constraints", "stage_cost") else state
            function.check_shape(*arguments)
            function.check_slopes(*arguments)
        return Problem(
            kernels_of(Callback(checked, len(cost.state_goal), len(cost.input_goal))),
            horizon=horizon, time_step=time_step, cost=cost, bounds=bounds or Bounds(),
            n_constraints=rows["constraints"], n_input_constraints=rows["input_constraints"],
            n_end_constraints=rows["end_constraints"], constraint_names=tuple(constraint_names),
            equalities=tuple(equalities),
        )  # fmt: skip
