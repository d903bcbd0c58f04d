"""acados, built for this processor: SQP and real-time iterations with HPIPM, generated C. Its own clock counts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from suite.peers.interface import Unsupported
from suite.standard.acados_program import Settings, solver_of
from suite.standard.peers.interface import StandardPeer
from suite.standard.task import Case, StandardTask
from suite.task import Answer

MOST_BLOCKS, BLOCKS = 10, {"cart_pole": 5, "unicycle": 5, "two_link_arm": 5}
"""Blocks of the condensed quadratic program: the fastest of 5, 10, one for each step, and one in all."""


class AcadosSqp(StandardPeer):
    """Gauss-Newton Hessian, full steps, tolerance 1e-6; replans are one iteration of the kind SQP_RTI."""

    settings = Settings()

    def __init__(self, task: StandardTask) -> None:
        super().__init__(task)
        settings = replace(self.settings, blocks=BLOCKS.get(task.name, MOST_BLOCKS))
        self._cold, self._one = (solver_of(task, settings, one) for one in (False, True))
        self._active, self._status = self._cold, 0

    def prepare_cold(self, case: Case) -> None:
        """The case's guess, multipliers zero."""
        self._active = self._cold
        self._cold.reset()
        self._guess(case)

    def prepare_replan(self, case: Case) -> None:
        """Shifted states and inputs; multipliers play no part in a full Gauss-Newton step."""
        following = self.follow(case)
        self._active = self._one
        self._guess(following)

    def solve(self) -> None:
        """One call of the solver."""
        self._status = self._active.solve()

    def own_seconds(self) -> float:
        """By acados' clock `time_tot`."""
        return float(self._active.get_stats("time_tot"))

    def answer(self) -> Answer:
        """Trajectory and acados' own verdict."""
        nodes = range(self.task.horizon)
        states = np.array([self._active.get(k, "x") for k in [*nodes, self.task.horizon]])
        inputs = np.array([self._active.get(k, "u") for k in nodes])
        iterations = int(self._active.get_stats("sqp_iter")) if self._active is self._cold else 1
        success = self._status == 0
        return Answer(states, inputs, iterations, f"status {self._status}", success, success)

    def _guess(self, case: Case) -> None:
        solver, n = self._active, self.task.horizon
        solver.set(0, "lbx", case.start)
        solver.set(0, "ubx", case.start)
        for k in range(n + 1):
            solver.set(k, "x", case.states[k])
            if k < n:
                solver.set(k, "u", case.inputs[k])
            if self.task.nq:
                solver.set(k, "p", case.node_parameters[k])


class FeasibleAcadosSqp(AcadosSqp):
    """Rows of a quadratic program that has no solution are relaxed first; the funnel's line search."""

    settings = Settings("SQP_WITH_FEASIBLE_QP", globalization="FUNNEL_L1PEN_LINESEARCH")

    def prepare_replan(self, case: Case) -> None:
        """A single iteration of the kind SQP_RTI relaxes nothing."""
        raise Unsupported("its single iteration is that of the row with full steps")


class SlackAcadosSqp(AcadosSqp):
    """Merit line search, and slacks with an exact linear price, so that every quadratic program has a solution."""

    settings = Settings(globalization="MERIT_BACKTRACKING", slack_price=1e2)
