"""What a symbolic problem is composed of besides dynamics: constraints and cost terms, each one expression with a name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from doorman.exceptions import SolverError

Place = Literal["stages", "end"]
Hessian = Literal["exact", "positive"]


@dataclass(frozen=True, eq=False)
class Constraint:
    """Rows that must not be positive: expression / scale ≤ 0.

    An expression of states holds at every state after the first. One that contains inputs holds at every node but the last.
    """

    name: str
    """For messages; rows of a vector are numbered."""
    expression: Any
    """CasADi SX, a number or a vector."""
    unit: str = ""
    """Of the expression, for messages."""
    scale: float = 1.0
    """What counts as much as 1 of other rows [unit]; the solver sees expression / scale."""
    at: Place = "stages"
    """"end": at the last state only."""

    def __post_init__(self) -> None:
        _check_name_and_place(self, "constraint")
        if not 0.0 < self.scale < float("inf"):
            raise SolverError("not a scale", field=f"{self.name}.scale", given=self.scale, allowed="> 0, finite")


@dataclass(frozen=True, eq=False)
class Cost:
    """A cost term of any form: at the stages a rate that is multiplied by Δt, at the end a number."""

    name: str
    expression: Any
    """CasADi SX, one number."""
    at: Place = "stages"
    """"end": of the last state only."""
    hessian: Hessian = "exact"
    """"exact" for a convex term; "positive" sets negative curvature to zero."""

    def __post_init__(self) -> None:
        _check_name_and_place(self, "cost")
        if self.hessian not in ("exact", "positive"):
            raise SolverError(
                "unknown", field=f"{self.name}.hessian", given=self.hessian, allowed="'exact' or 'positive'"
            )


@dataclass(frozen=True, eq=False)
class Residual:
    r"""Least squares :math:`\tfrac12 \sum_i w_i r_i^2` with the Hessian of Gauss and Newton; at the stages multiplied by Δt."""

    name: str
    expression: Any
    """r, CasADi SX, a number or a vector."""
    weights: Any = 1.0
    """w, one number for all or as many as r has, not negative; numbers or expressions of parameters."""
    at: Place = "stages"
    """"end": of the last state only."""

    def __post_init__(self) -> None:
        _check_name_and_place(self, "residual")


def _check_name_and_place(term: Any, what: str) -> None:
    if not (isinstance(term.name, str) and term.name):
        raise SolverError(f"a {what} needs a name", field="name", given=term.name, allowed="a text")
    if term.at not in ("stages", "end"):
        raise SolverError("no such place", field=f"{term.name}.at", given=term.at, allowed="'stages' or 'end'")
