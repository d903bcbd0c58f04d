"""doorman's planner of the whole-body push, called as a user calls it: everything inside counted."""

from __future__ import annotations

import doorman
from suite.standard.peers.interface import StandardPeer
from suite.standard.push import push_planner
from suite.standard.task import Case, StandardTask
from suite.task import Answer


class DoormanPush(StandardPeer):
    """`Planner.plan` and `Planner.replan(state)`; the planner fits the task's numbers itself."""

    def __init__(self, task: StandardTask) -> None:
        super().__init__(task)
        self._planner, self._warm, self._state = push_planner(), False, task.start_state.start
        self._plan: doorman.Plan | None = None

    def prepare_cold(self, case: Case) -> None:
        """Nothing but the state."""
        self._state, self._warm = case.start, False

    def prepare_replan(self, case: Case) -> None:
        """Nothing but the state."""
        self._state, self._warm = case.start, True

    def solve(self) -> None:
        """One call of the planner."""
        self._plan = (self._planner.replan if self._warm else self._planner.plan)(self._state)

    def answer(self) -> Answer:
        """The plan."""
        plan = self._plan
        assert plan is not None
        claim = plan.status.value
        return Answer(plan.states, plan.inputs, plan.iterations, claim, plan.flyable, claim == "converged")
