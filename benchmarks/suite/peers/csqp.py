"""mim_solvers' CSQP on a crocoddyl problem whose nodes are Python classes that call compiled CasADi functions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca
import crocoddyl  # must come before mim_solvers: it loads the libraries that those bindings need
import mim_solvers
import numpy as np

from suite.expressions import constraint_function, stage_cost_function, step_function, terminal_cost_function
from suite.peers.interface import Peer
from suite.peers.node_functions import NodeFunctions, dense
from suite.task import Answer, Array, Task, hover_guess, shifted

_COLD_ITERATIONS = 100


class Csqp(Peer):
    """Settings: QPs to 1e-6 absolute within 1,000 ADMM iterations, filter line search, KKT residual below 1e-4.

    With the defaults (1e-4, 1e-6) every state converges too, in more iterations.
    """

    def __init__(self, task: Task) -> None:
        super().__init__(task)
        self._functions = _compile(task)
        rows = [_Rows(task, node) for node in range(task.horizon + 1)]
        nodes = [_Node(task, self._functions, row) for row in rows]
        self._problem = crocoddyl.ShootingProblem(task.start_state, nodes[:-1], nodes[-1])
        self._solver = self._fresh()

    def prepare_cold(self, state: Array) -> None:
        """A solver without memory; guess: the state held, hover inputs."""
        self._solver = self._fresh()
        self._set(state, *hover_guess(self.task, state), _COLD_ITERATIONS)

    def prepare_replan(self, state: Array) -> None:
        """Shifted states and inputs; the solver keeps its multipliers as they are."""
        guess = shifted(np.array(self._solver.xs), np.array(self._solver.us))
        self._set(state, *guess, 1)

    def solve(self) -> None:
        """One call of the solver."""
        self._converged = self._solver.solve(self._states, self._inputs, self._limit, False)

    def answer(self) -> Answer:
        """Trajectory, and whether the residual fell below the tolerance."""
        states, inputs = np.array(self._solver.xs), np.array(self._solver.us)
        claim = "converged" if self._converged else "iteration limit"
        usable = self._converged or self._limit == 1
        return Answer(
            states, inputs, self._solver.iter, claim, usable, self._converged, self._functions.seconds
        )  # fmt: skip

    def _fresh(self) -> Any:
        solver = mim_solvers.SolverCSQP(self._problem)
        solver.eps_abs, solver.eps_rel, solver.max_qp_iters = 1e-6, 0.0, 1000
        solver.termination_tolerance = 1e-4
        return solver

    def _set(self, state: Array, states: Array, inputs: Array, limit: int) -> None:
        self._problem.x0 = state
        states[0] = state
        self._states, self._inputs, self._limit = list(states), list(inputs), limit
        self._functions.seconds = 0.0


class _Rows:
    """Which rows a node has: collision constraints after the first node, bounds where there are any."""

    def __init__(self, task: Task, node: int) -> None:
        self.first, self.last = node == 0, node == task.horizon
        none = np.full((2, 0), np.inf) * np.array([[-1.0], [1.0]])
        self.states, self.inputs = (
            np.flatnonzero(np.isfinite(bounds).any(axis=0)) if use else np.arange(0)
            for bounds, use in ((task.state_bounds, not self.first), (task.input_bounds, not self.last))
        )
        collision = none if self.first else np.array([[-np.inf] * task.nh, [0.0] * task.nh])
        self.bounds = np.hstack([collision, task.state_bounds[:, self.states], task.input_bounds[:, self.inputs]])


class _Node(crocoddyl.ActionModelAbstract):  # type: ignore[misc]
    """One node; crocoddyl calls it back for values and derivatives."""

    def __init__(self, task: Task, functions: NodeFunctions, rows: _Rows) -> None:
        self._task, self._functions, self._rows = task, functions, rows
        self._count = rows.bounds.shape[1]
        nu = 0 if rows.last else task.nu
        crocoddyl.ActionModelAbstract.__init__(self, crocoddyl.StateVector(task.nx), nu, 0, self._count, 0)
        if self._count:
            self.g_lb, self.g_ub = rows.bounds

    def createData(self) -> Any:
        """Memory of a node; the cost's Hessians and the bounds' Jacobians are constant."""
        data, task, rows = crocoddyl.ActionDataAbstract(self), self._task, self._rows
        data.Lxx = np.diag(task.terminal_weights if rows.last else task.time_step * task.state_weights)
        if not rows.last:
            data.Luu = np.diag(task.time_step * task.input_weights)
        self._jacobian = np.zeros((self._count, task.nx))
        collision = 0 if rows.first else task.nh
        self._jacobian[collision + np.arange(len(rows.states)), rows.states] = 1.0
        if len(rows.inputs):
            by_input = np.zeros((self._count, task.nu))
            by_input[collision + len(rows.states) + np.arange(len(rows.inputs)), rows.inputs] = 1.0
            data.Gu = by_input
        return data

    def calc(self, data: Any, x: Array, u: Array | None = None) -> None:
        """Next state, cost and rows."""
        if self._rows.last or u is None:
            cost, h = self._functions("terminal", x)
            data.xnext, data.cost, inputs = x, cost[0], np.zeros(0)
        else:
            after, cost, h = self._functions("node", x, u)
            data.xnext, data.cost, inputs = after, cost[0], u[self._rows.inputs]
        if self._count:
            data.g = np.concatenate([h[: 0 if self._rows.first else None], x[self._rows.states], inputs])

    def calcDiff(self, data: Any, x: Array, u: Array | None = None) -> None:
        """Their derivatives."""
        if self._rows.last or u is None:
            data.Lx, jacobian = self._functions("terminal_slopes", x)
        else:
            data.Fx, data.Fu, data.Lx, data.Lu, jacobian = self._functions("node_slopes", x, u)
        if not self._rows.first:
            self._jacobian[: len(jacobian)] = jacobian
            data.Gx = self._jacobian


def _compile(task: Task) -> NodeFunctions:
    x, u = ca.SX.sym("x", task.nx), ca.SX.sym("u", task.nu)
    after, h = step_function(task)(x, u), constraint_function(task)(x)
    stage, terminal = stage_cost_function(task)(x, u), terminal_cost_function(task)(x)
    slopes = [ca.jacobian(after, x), ca.jacobian(after, u), ca.gradient(stage, x), ca.gradient(stage, u)]
    functions = [
        dense("node", [x, u], [after, stage, h]),
        dense("node_slopes", [x, u], [*slopes, ca.jacobian(h, x)]),
        dense("terminal", [x], [terminal, h]),
        dense("terminal_slopes", [x], [ca.gradient(terminal, x), ca.jacobian(h, x)]),
    ]
    return NodeFunctions(Path("csqp", task.name.replace(" ", "_")).absolute(), functions)
