"""Optimal control problem: what is to be solved, without a word on how."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.checks import number
from doorman.exceptions import DimensionError
from doorman.ocp.problem.costs import QuadraticCost
from doorman.one_line import OneLine

FIRST_GOAL = 2
"""Place of the state's goal among the hidden parameters of a free time, after Δt and the weight of the duration."""


@dataclass(frozen=True, eq=False, repr=False)
class Bounds(OneLine):
    """Bounds of states after the first, and of inputs; an end that is not given, or infinite, does not bind."""

    state_lower: ArrayLike | None = None
    """Shape (nx,)."""
    state_upper: ArrayLike | None = None
    """Shape (nx,)."""
    input_lower: ArrayLike | None = None
    """Shape (nu,)."""
    input_upper: ArrayLike | None = None
    """Shape (nu,)."""

    def of_sizes(self, nx: int, nu: int) -> Bounds:
        """These bounds with checked arrays of full length.

        Args:
            nx: Number of states.
            nu: Number of inputs.

        Returns:
            Read-only arrays; an end that is not given is ±∞.

        Raises:
            DimensionError: if an array has the wrong length or holds NaN, or a lower bound lies above the upper one.
        """
        arrays: dict[str, Array] = {}
        for item in fields(self):
            size, end = (nx if item.name.startswith("state") else nu), (-np.inf if "lower" in item.name else np.inf)
            given = getattr(self, item.name)
            array = np.full(size, end) if given is None else np.array(given, dtype=np.float64)
            if array.shape != (size,) or np.isnan(array).any():
                raise DimensionError("not bounds", field=f"bounds.{item.name}", given=given, allowed=f"{size} numbers")
            array.flags.writeable = False
            arrays[item.name] = array
        for what in ("state", "input"):
            if (arrays[f"{what}_lower"] > arrays[f"{what}_upper"]).any():
                raise DimensionError(
                    "lower bound above the upper one", field=f"bounds.{what}_lower",
                    given=arrays[f"{what}_lower"].tolist(), allowed=f"<= {arrays[f'{what}_upper'].tolist()}",
                )  # fmt: skip
        return Bounds(**arrays)


@dataclass(frozen=True)
class FreeTime:
    r"""A duration T of the horizon that the solver chooses.

    J gets :math:`+ w T`, and costs of the stages become integrals over the chosen time. `horizon * time_step` is the guess of T.
    """

    lower: float
    """Shortest duration, above 0 [s]."""
    upper: float
    """Longest duration; may be infinite [s]."""
    weight: float = 1.0
    """w, cost of a second [1/s]."""

    def __post_init__(self) -> None:
        number(self.weight, "free_time.weight")
        if not (0.0 < number(self.lower, "free_time.lower", "> 0 s") < self.upper):
            raise DimensionError(
                "not a range of durations",
                field="free_time",
                given=(self.lower, self.upper),
                allowed="0 < lower < upper",
            )


@dataclass(frozen=True, eq=False, repr=False)
class Problem(OneLine):
    r"""Minimise a cost subject to dynamics, constraints and bounds.

    .. math::
        \min_U J(X, U)\quad\text{s.t.}\quad x_{k+1} = f(x_k, u_k),\quad h(x_{k+1}) \le 0,\quad g(x_k, u_k) \le 0,\quad
        h_N(x_N) \le 0,\quad \underline u \le u_k \le \bar u,\quad \underline x \le x_{k+1} \le \bar x,\quad k = 0 \ldots N-1

    J is the quadratic cost plus, where the model has them, `stage_cost` and `end_cost`.
    """

    model: Any
    """NamedTuple whose type has implementations of the functions in `doorman.ocp.kernels.functions`."""
    horizon: int
    """N, number of steps."""
    time_step: float
    """Δt [s]."""
    cost: QuadraticCost
    """Quadratic part of J; its goals say how many states and inputs there are."""
    n_constraints: int = 0
    """Rows of h, on every state after the first."""
    n_input_constraints: int = 0
    """Rows of g, on states and inputs."""
    n_end_constraints: int = 0
    """Rows of h_N, on the last state."""
    bounds: Bounds = field(default_factory=Bounds)
    """Bounds of states after the first, and of inputs."""
    integrators: int = 0
    """m: the last m states are x⁺ = x + Δt u of the last m inputs, and nothing else depends on these inputs. Declaring them
    saves time, nothing more."""
    constraint_names: tuple[str, ...] = ()
    """Names for messages, of the rows of h, g and h_N in this order; numbered where none are given."""
    equalities: tuple[bool, ...] = ()
    """Which of these rows are zero instead of not positive; none if not given."""
    free_time: FreeTime | None = None
    """Where the duration is free; `time_step` then makes the guess of it. The last state is the stretch of the time step, and the
    first value of the last input decides it: solvers neither take nor hand out these two."""
    hidden_parameters: int = 0
    """The model's first parameters that hold numbers of the problem, as a free time needs."""

    def __post_init__(self) -> None:
        for name, least in (
            ("horizon", 1), ("n_constraints", 0), ("n_input_constraints", 0), ("n_end_constraints", 0), ("integrators", 0)
        ):  # fmt: skip
            check_count(name, getattr(self, name), least)
        if not number(self.time_step, "time_step", "> 0 s") > 0.0:
            raise DimensionError("not a time step", field="time_step", given=self.time_step, allowed="> 0 s")
        if self.integrators > min(self.nx, self.nu):
            raise DimensionError(
                "more integrators than states or inputs", field="integrators", given=self.integrators,
                allowed=f"at most {min(self.nx, self.nu)}",
            )  # fmt: skip
        rows = self.n_constraints + self.n_input_constraints + self.n_end_constraints
        if self.constraint_names and len(self.constraint_names) != rows:
            raise DimensionError(
                "wrong number of names", field="constraint_names", given=len(self.constraint_names), allowed=str(rows)
            )
        if self.equalities and len(self.equalities) != rows:
            raise DimensionError(
                "wrong number of flags", field="equalities", given=len(self.equalities), allowed=str(rows)
            )
        object.__setattr__(self, "equalities", tuple(map(bool, self.equalities)) or (False,) * rows)
        object.__setattr__(self, "bounds", self.bounds.of_sizes(self.nx, self.nu))

    @property
    def nx(self) -> int:
        """Number of states."""
        return len(self.cost.state_goal)

    @property
    def nu(self) -> int:
        """Number of inputs."""
        return len(self.cost.input_goal)

    @property
    def given_states(self) -> int:
        """Number of states that solvers take and hand out."""
        return self.nx - (self.free_time is not None)

    @property
    def given_inputs(self) -> int:
        """Number of inputs that solvers take and hand out."""
        return self.nu - (self.free_time is not None)


def check_count(field: str, given: object, least: int) -> None:
    """Check a number of nodes, rows or states."""
    if not isinstance(given, int | np.integer):
        raise DimensionError("not a whole number", field=field, given=given, allowed=f">= {least}")
    if given < least:
        raise DimensionError("too small", field=field, given=given, allowed=f">= {least}")
