"""What a symbolic problem is composed of besides dynamics: constraints and cost terms, each one expression with a name."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from doorman.exceptions import SolverError

Place = Literal["stages", "end"]
Hessian = Literal["exact", "positive"]


@dataclass(frozen=True, eq=False)
class Constraint:
    """Rows that must not be positive, expression ≤ 0, or lower ≤ expression ≤ upper, or expression = equals.

    An expression of states holds at every state after the first. One that contains inputs holds at every node but the last.
    The solver sees each row divided by the scale. Ends are numbers, as many as the expression has or one for all, or CasADi
    expressions of parameters.
    """

    name: str
    """For messages; rows of a vector are numbered."""
    expression: Any
    """CasADi SX, a number or a vector."""
    unit: str = ""
    """Unit of the expression, for messages."""
    scale: float = 1.0
    """What counts as much as 1 of other rows [unit]; the solver sees expression / scale."""
    at: Place = "stages"
    """"end": at the last state only."""
    lower: Any = None
    """Lower end [unit]; none if not given, or where it is −inf."""
    upper: Any = None
    """Upper end [unit]; none if not given, or where it is inf; 0 where neither end nor `equals` is given."""
    equals: Any = None
    """What the expression is [unit]."""

    def __post_init__(self) -> None:
        _check_name_and_place(self, "constraint")
        if self.equals is not None and not (self.lower is None and self.upper is None):
            raise SolverError(
                "equals and other bounds are given together", field=f"{self.name}.equals", given=self.equals,
                allowed="either equals, or lower and upper",
            )  # fmt: skip
        if not 0.0 < self.scale < math.inf:
            raise SolverError("not a scale", field=f"{self.name}.scale", given=self.scale, allowed="> 0, finite")

    def rows(self, expression: Any, column: Callable[[str, Any], Any]) -> list[Row]:
        """One-sided rows and equalities of this constraint.

        Args:
            expression: This one, as a column.
            column: Makes a checked column of an end, given its name.

        Returns:
            The rows, in the order of the expression; where one has two ends, the upper one first.

        Raises:
            SolverError: if there are no ends, not as many as rows, or a lower one above the upper one.
        """
        count = int(expression.numel())
        if self.equals is not None:
            at = self._end("equals", self.equals, count, column)
            return [Row(expression[i] - at[i], True, self._row_name(i, count, "")) for i in range(count)]
        upper = 0.0 if self.lower is None and self.upper is None else self.upper
        ends = [
            (1.0, " upper", None if upper is None else self._end("upper", upper, count, column)),
            (-1.0, " lower", None if self.lower is None else self._end("lower", self.lower, count, column)),
        ]
        found = []
        for i in range(count):
            own = [
                (side, word, end[i]) for side, word, end in ends if end is not None and not _is_infinite(end[i], side)
            ]
            if len(own) == 2:
                highest, lowest = (end for _, _, end in own)
                if _is_above(lowest, highest):
                    raise SolverError(
                        "lower bound above the upper one", field=f"{self.name}.lower", given=str(lowest),
                        allowed=f"<= {highest}",
                    )  # fmt: skip
                if (highest - lowest).is_zero():
                    found.append(Row(expression[i] - highest, True, self._row_name(i, count, "")))
                    continue
            found += [
                Row(side * (expression[i] - end), False, self._row_name(i, count, word if len(own) == 2 else ""))
                for side, word, end in own
            ]
        if not found:
            raise SolverError("no finite bound", field=f"{self.name}", allowed="lower, upper or equals")
        return found

    def _end(self, which: str, given: Any, count: int, column: Callable[[str, Any], Any]) -> Any:
        end = column(f"{self.name}.{which}", given)
        if end.numel() not in (1, count):
            raise SolverError(
                "wrong number of bounds", field=f"{self.name}.{which}", given=end.numel(), allowed=f"1 or {count}"
            )
        return [end[i if end.numel() > 1 else 0] for i in range(count)]

    def _row_name(self, i: int, count: int, end: str) -> str:
        unit = f" [{self.unit}]" if self.unit else ""
        return f"{self.name}{f' {i}' if count > 1 else ''}{end}{unit}"


@dataclass(frozen=True, eq=False)
class Row:
    """One row of a constraint as the solver has it, but for the scale: not positive, or zero."""

    expression: Any
    equality: bool
    name: str


def _is_infinite(end: Any, side: float) -> bool:
    """Whether an end binds nothing."""
    return bool(end.is_constant()) and float(end) == side * math.inf


def _is_above(lower: Any, upper: Any) -> bool:
    """Whether numbers contradict each other; unknown for expressions."""
    return bool(lower.is_constant() and upper.is_constant()) and float(lower) > float(upper)


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
        raise SolverError("unknown place", field=f"{term.name}.at", given=term.at, allowed="'stages' or 'end'")
