"""doorman itself, called as a user calls it: `Hybrid.solve` and `Hybrid.replan`, everything inside counted."""

from __future__ import annotations

from doorman import ocp
from suite.standard.peers.interface import StandardPeer
from suite.standard.task import Case, StandardTask, example
from suite.task import Answer


class DoormanHybrid(StandardPeer):
    """`ocp.Hybrid` with its default options."""

    def __init__(self, task: StandardTask) -> None:
        super().__init__(task)
        self._solver = ocp.Hybrid(example(task.name).problem())
        self._warm, self._case, self._iterations = False, task.start_state, 0
        self._status = ocp.PlanStatus.DIVERGED

    def prepare_cold(self, case: Case) -> None:
        """Parameters and guess."""
        self._set(case, warm=False)

    def prepare_replan(self, case: Case) -> None:
        """Parameters: the solver keeps its previous trajectory."""
        self._set(case, warm=True)

    def solve(self) -> None:
        """One call of the solver."""
        if self._warm:
            self._status, self._iterations = self._solver.replan(self._case.start, elapsed=self.task.time_step)
            self._answer = self._solver.trajectory()
        else:
            solution = self._solver.solve(self._case.start, self._case.inputs, states=self._case.states)
            self._status, self._iterations = solution.status, solution.iterations
            self._answer = solution.states, solution.inputs

    def answer(self) -> Answer:
        """The trajectory and its status; a controller flies ways back into the constraints, too."""
        status = self._status
        usable = status.flyable if self._warm else status.usable
        return Answer(*self._answer, self._iterations, status.value, usable, status is ocp.PlanStatus.CONVERGED)

    def _set(self, case: Case, warm: bool) -> None:
        self._case, self._warm = case, warm
        if self.task.nq:
            self._solver.update_parameters(node_parameters=case.node_parameters)
