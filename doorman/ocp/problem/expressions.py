"""All expressions of one problem with their derivatives, ready to be printed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from doorman.exceptions import DimensionError
from doorman.ocp.problem.terms import Cost, Residual


@dataclass(frozen=True, eq=False)
class Expansion:
    """A cost of some variables z with its derivatives."""

    value: Any
    """Sum of all terms, (1, 1)."""
    gradient: Any
    """Gradient of terms that are no squares, (nz, 1)."""
    convex: Any
    """Hessian of what is convex and no square, (nz, nz)."""
    bent: Any
    """Hessian of which only the positive part counts, (nz, nz)."""
    residuals: Any
    """r of the squares ½ Σ w r², (nr, 1)."""
    weights: Any
    """w, (nr, 1)."""
    slopes: Any
    """∂r/∂z, (nr, nz)."""

    @classmethod
    def of(cls, terms: Sequence[tuple[Any, Any]], z: Any, factor: Any) -> Expansion:
        """Sum of terms, times a factor, with its derivatives."""
        size = z.numel()
        total, convex, bent = ca.SX(0), ca.SX(size, size), ca.SX(size, size)
        residuals, weights = ca.SX(0, 1), ca.SX(0, 1)
        for term, expression in terms:
            if isinstance(term, Residual):
                residuals = ca.vertcat(residuals, expression)
                weights = ca.vertcat(weights, _weights(term, expression.numel()))
                continue
            value = _one_number(term, expression)
            hessian = ca.hessian(value, z)[0]
            convex, bent = (convex + hessian, bent) if term.hessian == "exact" else (convex, bent + hessian)
            total += value
        return cls(
            factor * (total + 0.5 * ca.dot(residuals, weights * residuals)), factor * ca.gradient(total, z),
            factor * convex, factor * bent, residuals, factor * weights, ca.jacobian(residuals, z),
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Expressions:
    """Symbols and what is made of them."""

    x: Any
    u: Any
    time_step: Any
    parameters: Any
    node_parameters: Any
    rate: Any
    """ẋ, or x⁺ of discrete dynamics, (nx, 1)."""
    step: Any
    """x⁺, (nx, 1), of which slopes are taken."""
    checked_step: Any
    """x⁺, NaN where it leaves the domain, (nx, 1)."""
    rows: Any
    """h, (nh, 1)."""
    input_rows: Any
    """g, (ng, 1)."""
    end_rows: Any
    """h_N, (nt, 1)."""
    names: tuple[str, ...]
    """Names of the rows of h, g and h_N."""
    equalities: tuple[bool, ...]
    """Which of these rows are zero."""
    stage_cost: Expansion | None
    """Expansion by [x; u], times Δt; None if there is neither cost."""
    end_cost: Expansion | None
    """Expansion by x."""


def integrators_of(expressions: Expressions) -> int:
    """Number of the last states that are x⁺ = x + Δt u of the last inputs, on which nothing else depends."""
    x, u, h, step = expressions.x, expressions.u, expressions.time_step, ca.cse(expressions.step)
    nx, nu, count, stage = x.numel(), u.numel(), 0, expressions.stage_cost
    others = ca.vertcat(expressions.input_rows, *([] if stage is None else [stage.value]))
    while count < min(nx, nu):
        state, entry = nx - 1 - count, nu - 1 - count
        rest = ca.vertcat(*[step[i] for i in range(nx) if i != state])
        if ca.depends_on(ca.vertcat(rest, others), u[entry]) or ca.depends_on(rest, x[state]):
            break
        if not _is_sum(step[state], x[state], u[entry], h):
            break
        count += 1
    return count


def _is_sum(expression: Any, x: Any, u: Any, h: Any) -> bool:
    """Whether an expression is x + h u: of these symbols only, and so in value at a few places."""
    if any(not ca.depends_on(ca.vertcat(x, u, h), symbol) for symbol in ca.symvar(expression)):
        return False
    function = ca.Function("sum", [x, u, h], [expression - (x + h * u)])
    return all(abs(float(function(*each))) < 1e-12 for each in np.random.default_rng(0).uniform(-2.0, 2.0, (5, 3)))


def _weights(term: Residual, count: int) -> Any:
    """W, one for each of so many residuals."""
    weights = ca.vec(ca.SX(term.weights if isinstance(term.weights, ca.SX) else ca.DM(term.weights)))
    if weights.numel() not in (1, count):
        raise DimensionError(
            "wrong number of weights", field=f"{term.name}.weights", given=weights.numel(),
            allowed=f"1 or {count}",
        )  # fmt: skip
    return ca.densify(ca.repmat(weights, count // weights.numel(), 1))


def _one_number(term: Cost, expression: Any) -> Any:
    if expression.numel() != 1:
        raise DimensionError("not a single number", field=term.name, given=expression.numel(), allowed="1")
    return expression
