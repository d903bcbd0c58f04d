"""The judge: optima by an interior-point method, and what an answer is really worth, by CasADi's functions alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from suite.expressions import constraint_function, stage_cost_function, step_function, terminal_cost_function
from suite.peers.shooting import ProgramSolver, Shooting
from suite.task import Answer, Array, Task, hover_guess

TOLERANCE = 1e-6
"""Of a solved problem: relative excess of the cost, violation and defect."""

_REFERENCE = {
    "ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.max_iter": 1000,
    "ipopt.tol": 1e-9, "ipopt.constr_viol_tol": 1e-9, "ipopt.acceptable_tol": 1e-9,
}  # fmt: skip


@dataclass(frozen=True)
class Optimum:
    """What the interior-point reference finds."""

    states: Array
    inputs: Array
    cost: float
    success: bool


@dataclass(frozen=True)
class Verdict:
    """What an answer is worth."""

    cost: float
    """J of its states and inputs."""
    violation: float
    """Largest excess of a constraint or bound over 0 at the nodes 1 … N and in the inputs; 0 if none."""
    defect: float
    """Largest difference between a state and the step from the one before, the given start included."""
    rolled_violation: float
    """`violation` of the states that its inputs really lead to."""

    def solves(self, optimum: Optimum) -> bool:
        """Whether it is as good as the optimum (or better), and holds."""
        holds = max(self.violation, self.defect) <= TOLERANCE
        return bool(np.isfinite(self.cost)) and holds and self.gap(optimum) <= TOLERANCE

    def gap(self, optimum: Optimum) -> float:
        """Relative excess of the cost."""
        return self.cost / optimum.cost - 1.0


class Judge:
    """References and verdicts for one task."""

    def __init__(self, task: Task) -> None:
        self.task = task
        self.step = step_function(task)
        n = task.horizon
        self._steps, self._rollout = self.step.map(n), self.step.mapaccum(n)
        self._rows = constraint_function(task).map(n)
        self._stage, self._terminal = stage_cost_function(task).map(n), terminal_cost_function(task)
        options = {**_REFERENCE, "expand": n <= 100}  # beyond, expanding takes longer than it saves
        self._reference = ProgramSolver(Shooting(task), "ipopt", options)

    def optimum(self, state: Array, guess: tuple[Array, Array] | None = None) -> Optimum:
        """Solve from hover inputs, or from a guess."""
        self._reference.guess(state, *(guess or hover_guess(self.task, state)))
        self._reference.run()
        states, inputs = self._reference.trajectory()
        return Optimum(states, inputs, self._cost(states, inputs), bool(self._reference.stats["success"]))

    def verdict(self, state: Array, answer: Answer) -> Verdict:
        """Judge an answer to a start state."""
        states, inputs = answer.states, answer.inputs
        if not (np.isfinite(states).all() and np.isfinite(inputs).all()):
            return Verdict(np.inf, np.inf, np.inf, np.inf)
        gaps = np.array(self._steps(states[:-1].T, inputs.T)).T - states[1:]
        rolled = np.array(self._rollout(state, inputs.T)).T
        defect = max(np.abs(gaps).max(), np.abs(states[0] - state).max())
        return Verdict(
            self._cost(states, inputs),
            self._violation(states[1:], inputs),
            float(defect),
            self._violation(rolled, inputs),
        )

    def starts_at(self, state: Array) -> float:
        """Violation of the collision constraints at a state itself [m]; 0 if none."""
        return max(float(np.array(self._rows(np.tile(state, (self.task.horizon, 1)).T)).max()), 0.0)

    def recovery(self, answer: Answer) -> int:
        """First node from which on no constraint is violated; N + 1 if it never is."""
        h = np.array(self._rows(answer.states[1:].T)).max(axis=0)
        late = np.flatnonzero(h > TOLERANCE)
        return int(late[-1]) + 2 if len(late) else 1

    def _cost(self, states: Array, inputs: Array) -> float:
        return float(np.array(self._stage(states[:-1].T, inputs.T)).sum() + float(self._terminal(states[-1])))

    def _violation(self, states: Array, inputs: Array) -> float:
        task = self.task
        excesses = [np.array(self._rows(states.T)).max()]
        for values, bounds in ((states, task.state_bounds), (inputs, task.input_bounds)):
            excesses += [(bounds[0] - values).max(), (values - bounds[1]).max()]
        worst = float(np.max(excesses))
        return max(worst, 0.0) if np.isfinite(worst) else np.inf
