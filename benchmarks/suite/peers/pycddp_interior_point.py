"""pycddp's interior-point DDP, model and constraints as Python classes that call compiled CasADi functions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pycddp

from suite.expressions import constraint_function, step_function
from suite.peers.interface import Peer
from suite.peers.node_functions import NodeFunctions, dense
from suite.task import Answer, Array, Task

_ITERATIONS = 200


class InteriorPointDdp(Peer):
    """IPDDP with a barrier that starts at 0.1 and falls by 0.2: with the defaults the paper's start does not converge.

    The library constrains the nodes 0 … N − 1 by functions of state and input; here they are h of the *next* state, so that
    the nodes 1 … N are constrained. It forms A = 1 + Δt F_x: F_x is made so that A is that of the RK4 step.
    """

    def __init__(self, task: Task) -> None:
        super().__init__(task)
        self._functions = _compile(task)
        step, hover = step_function(task), np.tile(task.hover_input, (task.horizon, 1)).T
        self._rollout = lambda state: np.array(step.mapaccum(task.horizon)(state, hover)).T

    def prepare_cold(self, state: Array) -> None:
        """A solver without memory; guess: hover inputs, rolled out, as a single-shooting method needs it."""
        task = self.task
        options = pycddp.CDDPOptions()
        options.max_iterations, options.tolerance, options.acceptable_tolerance = _ITERATIONS, 1e-6, 1e-9
        options.verbose = options.print_solver_header = False
        options.ipddp.barrier.mu_initial, options.ipddp.barrier.mu_update_factor = 0.1, 0.2
        solver = pycddp.CDDP(state, task.goal_state, task.horizon, task.time_step, options)
        solver.set_dynamical_system(_Step(task, self._functions))
        halves = (0.5 * np.diag(w) for w in (task.state_weights, task.input_weights, task.terminal_weights))
        solver.set_objective(pycddp.QuadraticObjective(*halves, task.goal_state, [], task.time_step))
        solver.add_constraint("rows", _NextRows(task, self._functions))
        states = [state, *self._rollout(state)]
        solver.set_initial_trajectory(states, [np.zeros(task.nu)] * task.horizon)
        self._solver, self._functions.seconds = solver, 0.0

    def solve(self) -> None:
        """One call of the solver."""
        self._solution = self._solver.solve(pycddp.SolverType.IPDDP)

    def answer(self) -> Answer:
        """Trajectory and the library's own verdict; its inputs are relative to hover."""
        solution = self._solution
        claim = solution.status_message
        inputs = np.array(solution.control_trajectory) + self.task.hover_input
        usable = claim in ("OptimalSolutionFound", "AcceptableSolutionFound")
        states = np.array(solution.state_trajectory)
        return Answer(
            states, inputs, solution.iterations_completed, claim, usable, usable, self._functions.seconds
        )  # fmt: skip


class _Step(pycddp.DynamicalSystem):  # type: ignore[misc]
    """The RK4 step as a system of the library."""

    def __init__(self, task: Task, functions: NodeFunctions) -> None:
        super().__init__(task.nx, task.nu, task.time_step, "rk4")
        self._functions, self._step = functions, task.time_step

    def get_continuous_dynamics(self, state: Array, control: Array, time: float = 0.0) -> Array:
        """Mean derivative over the step."""
        return (self._functions("node", state, control)[0] - state) / self._step

    def get_discrete_dynamics(self, state: Array, control: Array, time: float = 0.0) -> Array:
        """Next state."""
        return self._functions("node", state, control)[0].copy()

    def get_state_jacobian(self, state: Array, control: Array, time: float = 0.0) -> Array:
        """(A − 1)/Δt."""
        return self._functions("slopes", state, control)[0].copy()

    def get_control_jacobian(self, state: Array, control: Array, time: float = 0.0) -> Array:
        """B/Δt."""
        return self._functions("slopes", state, control)[1].copy()


class _NextRows(pycddp.Constraint):  # type: ignore[misc]
    """Constraints of the next state, and bounds of the input where there are any."""

    def __init__(self, task: Task, functions: NodeFunctions) -> None:
        super().__init__("rows")
        self._functions, self._task = functions, task
        self._count = len(functions("node", task.start_state, np.zeros(task.nu))[1])

    def get_dual_dim(self) -> int:
        """Number of rows."""
        return self._count

    def evaluate(self, state: Array, control: Array, index: int = 0) -> Array:
        """Values, allowed where not positive."""
        return self._functions("node", state, control)[1].copy()

    def get_lower_bound(self) -> Array:
        """None."""
        return np.full(self._count, -np.inf)

    def get_upper_bound(self) -> Array:
        """Zero."""
        return np.zeros(self._count)

    def get_state_jacobian(self, state: Array, control: Array, index: int = 0) -> Array:
        """By the present state."""
        return self._functions("slopes", state, control)[2].copy()

    def get_control_jacobian(self, state: Array, control: Array, index: int = 0) -> Array:
        """By the present input."""
        return self._functions("slopes", state, control)[3].copy()

    def compute_violation(self, state: Array, control: Array, index: int = 0) -> float:
        """Sum of the excesses."""
        return self.compute_violation_from_value(self._functions("node", state, control)[1])

    def compute_violation_from_value(self, g: Array) -> float:
        """Sum of the excesses."""
        return float(np.maximum(g, 0.0).sum())

    def get_center(self) -> Array:
        """Asked for, used by ball constraints only."""
        return np.zeros(self._task.nx)

    def get_state_hessian(self, state: Array, control: Array, index: int = 0) -> list[Array]:
        """Left out, as in iLQR."""
        return [np.zeros((self._task.nx, self._task.nx))] * self._count

    def get_control_hessian(self, state: Array, control: Array, index: int = 0) -> list[Array]:
        """Left out, as in iLQR."""
        return [np.zeros((self._task.nu, self._task.nu))] * self._count

    def get_cross_hessian(self, state: Array, control: Array, index: int = 0) -> list[Array]:
        """Left out, as in iLQR."""
        return [np.zeros((self._task.nu, self._task.nx))] * self._count


def _compile(task: Task) -> NodeFunctions:
    x, v = ca.SX.sym("x", task.nx), ca.SX.sym("v", task.nu)
    after = step_function(task)(x, v + ca.DM(task.hover_input))
    rows = [constraint_function(task)(after)]
    input_bounds = task.input_bounds - task.hover_input
    for value, bounds in ((after, task.state_bounds), (v, input_bounds)):
        rows += [value[int(i)] - bounds[1, i] for i in np.flatnonzero(np.isfinite(bounds[1]))]
        rows += [bounds[0, i] - value[int(i)] for i in np.flatnonzero(np.isfinite(bounds[0]))]
    g = ca.vertcat(*rows)
    by_state = (ca.jacobian(after, x) - ca.DM.eye(task.nx)) / task.time_step
    slopes: list[Any] = [by_state, ca.jacobian(after, v) / task.time_step, ca.jacobian(g, x), ca.jacobian(g, v)]
    functions = [dense("node", [x, v], [after, g]), dense("slopes", [x, v], slopes)]
    return NodeFunctions(Path("pycddp", task.name.replace(" ", "_")).absolute(), functions)
