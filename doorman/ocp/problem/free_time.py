r"""A duration that is not given: the horizon is stretched by a factor σ, which the input of the first node decides.

With σ as a last state and its value as a last input c,

.. math::
    x_{k+1} = f(x_k, u_k, \sigma_k \Delta t),\qquad \sigma_0 = c_0,\quad \sigma_{k+1} = \sigma_k,\qquad
    J = \sum_k \ell(x_k, u_k)\,\sigma_k\Delta t + \ell_N(x_N) + w T,\quad T = \sigma N\Delta t

there is one duration by construction, and no equality says so. c of later nodes acts on nothing; it is held at 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from doorman.arrays import Array
from doorman.checks import number
from doorman.exceptions import SolverError
from doorman.ocp.problem.costs import QuadraticCost
from doorman.ocp.problem.problem import Bounds, FreeTime
from doorman.ocp.problem.terms import Cost, Residual


@dataclass(frozen=True, eq=False)
class Stretched:
    """Symbols and expressions of a model with its stretch."""

    x: Any
    u: Any
    dynamics: Any
    time_step: Any
    """Δt, a hidden parameter, as are the next three."""
    price: Any
    """w."""
    goals: Any
    """Of state and input."""
    weights: Any
    """Of the quadratic cost's stages: their diagonal, or a root of the whole matrix."""
    node_parameters: Any
    """Those of the model, and 1 at the first node, 0 at the others."""
    stretch: Any
    """σ of a node."""

    @classmethod
    def of(cls, x: Any, u: Any, step: Any, time_step: Any, node_parameters: Any, is_full: bool) -> Stretched:
        """Stretched time, from a model's symbols and its x⁺ in terms of Δt."""
        sigma, choice, first = ca.SX.sym("stretch"), ca.SX.sym("duration"), ca.SX.sym("first")
        size, own_step = x.numel() + u.numel(), ca.SX.sym("given_step")
        stretch = first * choice + (1.0 - first) * sigma
        return cls(
            ca.vertcat(x, sigma), ca.vertcat(u, choice),
            ca.vertcat(ca.substitute(step, time_step, stretch * own_step), stretch), own_step, ca.SX.sym("price"),
            ca.SX.sym("goal", size), ca.SX.sym("weight", size * size if is_full else size),
            ca.vertcat(node_parameters, first), stretch,
        )  # fmt: skip

    def costs(self, given: Sequence[Cost | Residual], is_full: bool) -> list[Cost | Residual]:
        """Terms as integrals over the stretched time, the quadratic cost's stages among them."""
        first, choice, root = self.node_parameters[-1], self.u[-1], ca.sqrt(self.stretch)
        error, size = ca.vertcat(self.x[:-1], self.u[:-1]) - self.goals, self.goals.numel()
        found: list[Cost | Residual] = [
            Cost("the duration", self.price * self.stretch),
            Residual("a duration without effect", (1.0 - first) * (choice - 1.0)),
            Residual("the quadratic cost", root * (ca.reshape(self.weights, size, size) @ error))
            if is_full else Residual("the quadratic cost", root * error, self.weights),
        ]  # fmt: skip
        for term in given:
            if term.at == "end":
                found.append(term)
            elif isinstance(term, Residual):
                found.append(Residual(term.name, root * ca.vec(ca.SX(term.expression)), term.weights))
            else:  # a product is not convex even where the term is
                found.append(Cost(term.name, self.stretch * term.expression, hessian="positive"))
        return found

    @property
    def hidden(self) -> Any:
        """Parameters that hold numbers of the problem, see `hidden_numbers`."""
        return ca.vertcat(self.time_step, self.price, self.goals, self.weights)


def hidden_numbers(cost: QuadraticCost, time_step: float, free_time: FreeTime) -> Array:
    """Values of `Stretched.hidden`."""
    state, _, inputs, cross = cost.matrices()
    if cost.is_full:
        values, vectors = np.linalg.eigh(np.block([[state, cross.T], [cross, inputs]]))
        weights = (np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T).ravel(order="F")
    else:
        weights = np.concatenate([np.diag(state), np.diag(inputs)])
    return np.concatenate([[time_step, free_time.weight], cost.state_goal, cost.input_goal, weights])


def stretched_cost(cost: QuadraticCost) -> QuadraticCost:
    """What is left of a quadratic cost: that of the end."""
    nx, nu = len(cost.state_goal), len(cost.input_goal)
    _, terminal, _, _ = cost.matrices()
    diagonal = cost.terminal_weights.ndim == 1
    end = np.append(cost.terminal_weights, 0.0) if diagonal else np.pad(terminal, (0, 1))
    return QuadraticCost(
        np.zeros(nx + 1), end, np.zeros(nu + 1), np.append(cost.state_goal, 1.0), np.append(cost.input_goal, 1.0)
    )


def stretched_bounds(bounds: Bounds, nx: int, nu: int, free_time: FreeTime, guess: float) -> Bounds:
    """Bounds with those of the stretch, as the ratio of durations to the guess."""
    own = bounds.of_sizes(nx, nu)
    ends = (
        (own.state_lower, -np.inf),
        (own.state_upper, np.inf),
        (own.input_lower, free_time.lower),
        (own.input_upper, free_time.upper),
    )
    state_lower, state_upper, input_lower, input_upper = (np.append(np.asarray(given), more) for given, more in ends)
    input_lower[-1] /= guess
    input_upper[-1] /= guess
    return Bounds(state_lower, state_upper, input_lower, input_upper)


def check_guess(free_time: FreeTime, guess: float) -> None:
    """Check that horizon · time_step lies between the bounds."""
    number(guess, "horizon * time_step", "a finite time [s]")
    if not free_time.lower < guess < free_time.upper:
        raise SolverError(
            "the guess of the duration is outside its bounds", field="horizon * time_step", given=guess,
            allowed=f"between free_time.lower = {free_time.lower:g} s and free_time.upper = {free_time.upper:g} s",
        )  # fmt: skip
