"""What the toys have in common: a problem of doorman's, the same in CasADi's terms, and IPOPT's solution of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from doorman.ocp import Problem

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Toy:
    """A problem and its equations once more, as CasADi expressions that share nothing with the kernels."""

    problem: Problem
    start: Array
    advance: Callable[[Any, Any], Any]
    """x⁺ of x and u."""
    rows: Callable[[Any], Any]
    """h of x, at least one row."""

    def roll_out(self, inputs: Array) -> Array:
        """States from the start, by the equations here."""
        states = [self.start]
        for u in inputs:
            states.append(np.array(self.advance(ca.DM(states[-1]), ca.DM(u))).ravel())
        return np.array(states)

    def violation(self, states: Array, inputs: Array) -> float:
        """Largest violated row or bound, by the equations here."""
        bounds, ahead = self.problem.bounds, states[1:]
        sides = [
            bounds.state_lower - ahead, ahead - bounds.state_upper,
            bounds.input_lower - inputs, inputs - bounds.input_upper,
            np.array([np.array(self.rows(ca.DM(x))).ravel() for x in ahead]),
        ]  # fmt: skip
        return max(0.0, *(float(side.max()) for side in sides))

    def reference(self, inputs: Array | None = None) -> Reference:
        """IPOPT's local optimum by multiple shooting, from the guess that doorman's solvers begin with.

        Args:
            inputs: Guess of the inputs, shape (N, nu); rolled out. The input goal if not given.
        """
        problem, n = self.problem, self.problem.horizon
        cost, nx, nu, dt = problem.cost, problem.nx, problem.nu, problem.time_step
        z = ca.SX.sym("z", nu + nx, n)
        x, total, rows = ca.DM(self.start), 0.0, []
        for k in range(n):
            u, after = z[:nu, k], z[nu:, k]
            off, effort = x - cost.state_goal, u - cost.input_goal
            total += 0.5 * dt * (ca.dot(cost.state_weights, off**2) + ca.dot(cost.input_weights, effort**2))
            rows += [after - self.advance(x, u), self.rows(after)]
            x = after
        total += 0.5 * ca.dot(cost.terminal_weights, (x - cost.state_goal) ** 2)
        settings = {
            "ipopt.tol": 1e-10, "ipopt.constr_viol_tol": 1e-10, "ipopt.acceptable_tol": 1e-10, "ipopt.print_level": 0,
            "ipopt.bound_relax_factor": 0.0, "ipopt.sb": "yes", "print_time": False, "ipopt.max_iter": 1000,
        }  # fmt: skip
        solve = ca.nlpsol("toy", "ipopt", {"x": ca.vec(z), "f": total, "g": ca.vertcat(*rows)}, settings)
        nh = rows[1].numel()
        guess = np.tile(cost.input_goal, (n, 1)) if inputs is None else inputs
        result = solve(
            x0=np.hstack([guess, self.roll_out(guess)[1:]]).ravel(),
            lbx=np.tile(np.concatenate([problem.bounds.input_lower, problem.bounds.state_lower]), n),
            ubx=np.tile(np.concatenate([problem.bounds.input_upper, problem.bounds.state_upper]), n),
            lbg=np.tile(np.concatenate([np.zeros(nx), np.full(nh, -np.inf)]), n), ubg=0.0,
        )  # fmt: skip
        assert solve.stats()["success"], solve.stats()["return_status"]
        optimum = np.array(result["x"]).reshape(n, nu + nx)
        states = np.vstack([self.start, optimum[:, nu:]])
        return Reference(states, optimum[:, :nu], float(result["f"]))


@dataclass(frozen=True)
class Reference:
    """An optimum that doorman's solvers had no part in."""

    states: Array
    inputs: Array
    cost: float
