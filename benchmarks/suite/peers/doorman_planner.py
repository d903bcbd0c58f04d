"""doorman itself, called as a user calls it: `Planner.plan` and `Planner.replan`, everything inside counted."""

from __future__ import annotations

import doorman
from suite.peers.interface import Peer
from suite.task import Answer, Array, Task


class DoormanPlanner(Peer):
    """`replan(state)`: the planner looks itself for how far it has come along the previous plan."""

    elapsed: float | None = None

    def __init__(self, task: Task) -> None:
        super().__init__(task)
        self.planner = doorman.Planner(doorman.Scenario.load("paper", task.overrides))
        self._state, self._warm = task.start_state, False
        self._plan: doorman.Plan | None = None

    def prepare_cold(self, state: Array) -> None:
        """Nothing but the state."""
        self._state, self._warm = state, False

    def prepare_replan(self, state: Array) -> None:
        """Nothing but the state: the planner keeps its previous plan."""
        self._state, self._warm = state, True

    def solve(self) -> None:
        """One call of the planner."""
        if self._warm:
            self._plan = self.planner.replan(self._state, elapsed=self.elapsed)
        else:
            self._plan = self.planner.plan(self._state)

    def answer(self) -> Answer:
        """The plan."""
        plan = self._plan
        assert plan is not None
        claim = plan.status.value
        return Answer(plan.states, plan.inputs, plan.iterations, claim, plan.usable, claim == "converged")


class TimedDoormanPlanner(DoormanPlanner):
    """`replan(state, elapsed=…)`: the planner is told that one step has passed."""

    def __init__(self, task: Task) -> None:
        super().__init__(task)
        self.elapsed = task.time_step
