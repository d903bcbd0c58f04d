"""A standard problem as a sparse nonlinear program by multiple shooting, in the order of the nodes."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from suite.buffered_program import BufferedProgram
from suite.standard.task import Array, Case, StandardTask


class Shooting:
    """Variables [x_0 u_0 x_1 … x_N]; rows [gap_0, x_0 − p, rows_0, gap_1, rows_1 … rows_N]; parameters [start, those of nodes].

    The functions of a node are mapped over the nodes, so that generated C is a loop that compiles in seconds.

    Args:
        task: The task.
        initial_rows: Fix x_0 by rows; otherwise by equal bounds.
    """

    def __init__(self, task: StandardTask, *, initial_rows: bool = False) -> None:
        self.task, self.initial_rows = task, initial_rows
        n, nx, nu, nq = task.horizon, task.nx, task.nu, task.nq
        variables, parameters = ca.MX.sym("w", n * (nx + nu) + nx), ca.MX.sym("p", nx + nq * (n + 1))
        nodes = ca.reshape(variables[: n * (nx + nu)], nx + nu, n)
        states, inputs, last = nodes[:nx, :], nodes[nx:, :], variables[-nx:]
        at = ca.reshape(parameters[nx:], nq, n + 1)
        step, rows, state_rows, end_rows, stage, end = (
            task.function(name) for name in ("step", "rows", "state_rows", "end_rows", "stage_residual", "end_residual")
        )
        after = ca.horzcat(states[:, 1:], last)
        gaps = after - step.map(n)(states, inputs, at[:, :n])
        at_inputs = rows.map(n)(states, inputs, at[:, :n])
        at_states = state_rows.map(n)(after, at[:, 1:])
        residuals = stage.map(n)(states, inputs, at[:, :n])
        start = [states[:, 0] - parameters[:nx]] if initial_rows else []
        between = ca.vertcat(gaps[:, 1:], at_states[:, :-1], at_inputs[:, 1:])
        last_rows = ca.vertcat(at_states[:, -1], end_rows(last, at[:, n]))
        self.residuals = ca.vertcat(ca.vec(residuals), end(last, at[:, n]))
        self.program: dict[str, Any] = {
            "x": variables, "p": parameters, "f": 0.5 * ca.sumsqr(self.residuals),
            "g": ca.vertcat(gaps[:, 0], *start, at_inputs[:, 0], ca.vec(between), last_rows),
        }  # fmt: skip
        ng, nh = rows.size1_out(0), state_rows.size1_out(0)
        self.equal = np.array(
            [True] * nx * (1 + initial_rows) + [False] * ng
            + ([True] * nx + [False] * (nh + ng)) * (n - 1)
            + [False] * (nh + end_rows.size1_out(0))
        )  # fmt: skip
        self.lower_rows, self.upper_rows = np.where(self.equal, 0.0, -np.inf), np.zeros(len(self.equal))
        self.lower, self.upper = (self._bounds(side) for side in (0, 1))
        self.rows_of_nodes = [ng, *[nh + ng] * (n - 1), nh + end_rows.size1_out(0)]
        """Inequality rows of every node."""

    def pack(self, states: Array, inputs: Array) -> Array:
        """Variables from states (N + 1, nx) and inputs (N, nu)."""
        return np.concatenate([np.hstack([states[:-1], inputs]).ravel(), states[-1]])

    def unpack(self, variables: Array) -> tuple[Array, Array]:
        """States and inputs from variables."""
        nodes = variables[: -self.task.nx].reshape(self.task.horizon, -1)
        return np.vstack([nodes[:, : self.task.nx], variables[-self.task.nx :]]), nodes[:, self.task.nx :].copy()

    def parameters(self, case: Case) -> Array:
        """Of a case."""
        return np.concatenate([case.start, case.node_parameters.ravel()])

    def _bounds(self, side: int) -> Array:
        states = np.tile(self.task.state_bounds[side], (self.task.horizon + 1, 1))
        states[0] = (-np.inf, np.inf)[side]
        return self.pack(states, np.tile(self.task.input_bounds[side], (self.task.horizon, 1)))


class ProgramSolver(BufferedProgram):
    """An `nlpsol` solver of a shooting program."""

    def __init__(self, shooting: Shooting, plugin: str, options: dict[str, Any]) -> None:
        super().__init__(shooting, plugin, {"error_on_fail": False, **options})
        self.shooting = shooting

    def guess(self, case: Case) -> None:
        """Set start, parameters and first guess; multipliers start from zero."""
        nx = self.shooting.task.nx
        if not self.shooting.initial_rows:
            self._in["lbx"][:nx] = self._in["ubx"][:nx] = case.start
        self._in["p"][:] = self.shooting.parameters(case)
        self._in["x0"][:] = self.shooting.pack(case.states, case.inputs)
        self._in["x0"][:nx] = case.start
