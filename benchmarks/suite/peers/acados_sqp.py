"""acados, built for this processor, on the door's problem: see `suite.standard.peers.acados_sqp`."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from suite.expressions import constraint_function, step_function
from suite.peers.interface import Peer
from suite.standard.peers import acados_sqp as standard
from suite.standard.task import Case, StandardTask
from suite.task import Answer, Array, Task, hover_guess


class AcadosSqp(Peer):
    """Gauss-Newton Hessian, constant for this cost; full steps; replans are one iteration of the kind SQP_RTI."""

    def __init__(self, task: Task) -> None:
        super().__init__(task)
        self._solver = standard.AcadosSqp(_as_standard(task))

    def prepare_cold(self, state: Array) -> None:
        """Guess: the state held, hover inputs."""
        self._solver.prepare_cold(_case(state, *hover_guess(self.task, state)))

    def prepare_replan(self, state: Array) -> None:
        """Shifted states and inputs."""
        self._solver.prepare_replan(_case(state, *hover_guess(self.task, state)))

    def solve(self) -> None:
        """One call of the solver."""
        self._solver.solve()

    def own_seconds(self) -> float:
        """By acados' clock."""
        return self._solver.own_seconds()

    def answer(self) -> Answer:
        """Trajectory and acados' own verdict."""
        return self._solver.answer()


def _case(state: Array, states: Array, inputs: Array) -> Case:
    return Case(state, np.zeros((len(states), 0)), states, inputs)


def _as_standard(task: Task) -> StandardTask:
    """The same problem in the form of the standard ones."""
    x, u, q = ca.SX.sym("x", task.nx), ca.SX.sym("u", task.nu), ca.SX.sym("q", 0)
    from_goal, from_hover = x - ca.DM(task.goal_state), u - ca.DM(task.hover_input)
    stage = np.sqrt(task.time_step) * ca.vertcat(
        ca.DM(np.sqrt(task.state_weights)) * from_goal, ca.DM(np.sqrt(task.input_weights)) * from_hover
    )
    none = ca.SX(0, 1)
    functions = {
        "step": ca.Function("f", [x, u, q], [step_function(task)(x, u)]),
        "rows": ca.Function("f", [x, u, q], [none]),
        "state_rows": ca.Function("f", [x, q], [constraint_function(task)(x)]),
        "end_rows": ca.Function("f", [x, q], [none]),
        "stage_residual": ca.Function("f", [x, u, q], [stage]),
        "end_residual": ca.Function("f", [x, q], [ca.DM(np.sqrt(task.terminal_weights)) * from_goal]),
    }
    texts: dict[str, Any] = {name: function.serialize() for name, function in functions.items()}
    start = _case(task.start_state, *hover_guess(task, task.start_state))
    return StandardTask(
        task.name, task.name, task.horizon, task.time_step, task.nx, task.nu, 0, texts, task.state_bounds,
        task.input_bounds, start,
    )  # fmt: skip
