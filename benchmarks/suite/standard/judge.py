"""What an answer to a standard problem is worth, by CasADi's functions alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suite.standard.task import Array, Case, StandardTask

TOLERANCE = 1e-6
"""Of violation and defect."""


@dataclass(frozen=True)
class Verdict:
    """Cost, largest violation of a constraint or bound, and largest gap of the dynamics."""

    cost: float
    violation: float
    defect: float

    @property
    def holds(self) -> bool:
        """Whether dynamics and constraints hold."""
        return bool(np.isfinite(self.cost)) and max(self.violation, self.defect) <= TOLERANCE


class Judge:
    """Verdicts on answers to one task."""

    def __init__(self, task: StandardTask) -> None:
        n = task.horizon
        self.task = task
        self.step = task.function("step")
        self._steps, self._rows = self.step.map(n), task.function("rows").map(n)
        self._state_rows, self._stage = task.function("state_rows").map(n), task.function("stage_residual").map(n)
        self._end_rows, self._end = task.function("end_rows"), task.function("end_residual")

    def verdict(self, case: Case, states: Array, inputs: Array) -> Verdict:
        """Judge states (N + 1, nx) and inputs (N, nu)."""
        if not (np.isfinite(states).all() and np.isfinite(inputs).all()):
            return Verdict(np.inf, np.inf, np.inf)
        x, u, q, last = states[:-1].T, inputs.T, case.node_parameters.T, states[-1]
        gaps = np.array(self._steps(x, u, q[:, :-1])).T - states[1:]
        cost = 0.5 * (
            np.sum(np.array(self._stage(x, u, q[:, :-1])) ** 2) + np.sum(np.array(self._end(last, q[:, -1])) ** 2)
        )
        rows = [
            np.array(found)
            for found in (
                self._rows(x, u, q[:, :-1]), self._state_rows(states[1:].T, q[:, 1:]), self._end_rows(last, q[:, -1])
            )
        ]  # fmt: skip
        beyond = [
            np.maximum(bounds[0] - values, values - bounds[1])
            for values, bounds in ((states[1:], self.task.state_bounds), (inputs, self.task.input_bounds))
        ]
        violation = max(array.max(initial=0.0) for array in [*rows, *beyond])
        defect = max(np.abs(gaps).max(), np.abs(states[0] - case.start).max())
        return Verdict(float(cost), float(violation), float(defect))
