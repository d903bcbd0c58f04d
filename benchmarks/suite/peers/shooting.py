"""The task as a sparse nonlinear program by multiple shooting, in the order that structure-exploiting solvers expect."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from suite.buffered_program import BufferedProgram
from suite.expressions import constraint_function, stage_cost_function, step_function, terminal_cost_function
from suite.task import Array, Task

COMPILED = {"jit": True, "compiler": "shell", "jit_options": {"flags": ["-O3", "-march=native"], "verbose": False}}
"""CasADi options: generate C for the program's functions and derivatives, and compile it."""


class Shooting:
    """Variables [x_0 u_0 x_1 … x_N]; rows [gap_0, gap_1 h_1, …, gap_{N−1} h_{N−1}, h_N].

    The functions of a node are mapped over the nodes, so that generated C is a loop that compiles in seconds; unrolled it
    takes minutes to compile and runs no faster.

    Args:
        task: The task.
        initial_rows: Fix x_0 by rows after gap_0 and a parameter; otherwise by equal bounds.
    """

    def __init__(self, task: Task, *, initial_rows: bool = False) -> None:
        self.task = task
        n, nx, nu, nh = task.horizon, task.nx, task.nu, task.nh
        self.size = n * (nx + nu) + nx
        variables = ca.MX.sym("w", self.size)
        start = ca.MX.sym("p", nx if initial_rows else 0)
        nodes = ca.reshape(variables[: n * (nx + nu)], nx + nu, n)
        states, inputs = ca.horzcat(nodes[:nx, :], variables[-nx:]), nodes[nx:, :]
        gaps = states[:, 1:] - step_function(task).map(n)(states[:, :-1], inputs)
        rows = constraint_function(task).map(n)(states[:, 1:])
        first = [gaps[:, 0], states[:, 0] - start] if initial_rows else [gaps[:, 0]]
        cost = ca.sum2(stage_cost_function(task).map(n)(states[:, :-1], inputs))
        self.program: dict[str, Any] = {
            "x": variables,
            "p": start,
            "f": cost + terminal_cost_function(task)(states[:, -1]),
            "g": ca.vertcat(*first, ca.vec(ca.vertcat(gaps[:, 1:], rows[:, :-1])), rows[:, -1]),
        }
        equal = [True] * (nx * len(first)) + ([True] * nx + [False] * nh) * (n - 1) + [False] * nh
        self.equal = np.array(equal)
        self.lower_rows = np.where(self.equal, 0.0, -np.inf)
        self.upper_rows = np.zeros(len(equal))
        self.lower, self.upper = (self._bounds(side) for side in (0, 1))

    def pack(self, states: Array, inputs: Array) -> Array:
        """Variables from states (N + 1, nx) and inputs (N, nu)."""
        return np.concatenate([np.hstack([states[:-1], inputs]).ravel(), states[-1]])

    def unpack(self, variables: Array) -> tuple[Array, Array]:
        """States and inputs from variables."""
        n, nx = self.task.horizon, self.task.nx
        nodes = variables[:-nx].reshape(n, -1)
        return np.vstack([nodes[:, :nx], variables[-nx:]]), nodes[:, nx:].copy()

    def _bounds(self, side: int) -> Array:
        task = self.task
        states = np.tile(task.state_bounds[side], (task.horizon + 1, 1))
        states[0] = (-np.inf, np.inf)[side]
        return self.pack(states, np.tile(task.input_bounds[side], (task.horizon, 1)))


class ProgramSolver(BufferedProgram):
    """An `nlpsol` solver of a shooting program, see `BufferedProgram`.

    Args:
        shooting: The program.
        plugin: Name of CasADi's plugin.
        options: Options of `nlpsol`.
        fix_start: Whether x_0 is fixed by bounds; otherwise by the parameter.
    """

    def __init__(self, shooting: Shooting, plugin: str, options: dict[str, Any], *, fix_start: bool = True) -> None:
        super().__init__(shooting, plugin, options)
        self.shooting = shooting
        self._fix_start = fix_start

    def guess(self, state: Array, states: Array, inputs: Array) -> None:
        """Set the start and the first guess of states and inputs; multipliers start from zero."""
        nx = self.shooting.task.nx
        if self._fix_start:
            self._in["lbx"][:nx] = self._in["ubx"][:nx] = state
        else:
            self._in["p"][:] = state
        self._in["x0"][:] = self.shooting.pack(states, inputs)
        self._in["x0"][:nx] = state
