"""Constrained differential dynamic programming: every iterate satisfies dynamics and nonlinear constraints."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.checks import vector
from doorman.exceptions import DimensionError
from doorman.ocp import augmented_lagrangian
from doorman.ocp import backward as backward_pass
from doorman.ocp import forward as forward_pass
from doorman.ocp.problem import Problem
from doorman.ocp.riccati import terminal_value
from doorman.ocp.solution import PlanStatus, Solution
from doorman.ocp.stage_qp import StageQpSolver
from doorman.ocp.workspace import Workspace

Array = NDArray[np.float64]

_LARGEST_RISE = -1e-6
"""Rows that a rollout leaves violated by its tolerance may cost this much to restore, relative to 1 + |cost|."""


@dataclass(frozen=True)
class CddpOptions:
    """Settings of the solver."""

    tolerance: float = 1e-9
    """Converged when the predicted decrease of the cost is below this, relative to 1 + |cost|."""
    guess_active_sets: bool = True
    """Try a guess of a node's active set before ProxQP is asked; a guess counts only if it solves the node exactly."""
    smallest_step: float = 1.0 / 64.0
    """Shortest step of the line search before regularisation grows."""
    sufficient_decrease: float = 1e-4
    """Share of the predicted decrease that a step must bring."""
    first_regularization: float = 1e-3
    """Relative addition to the input weights after a line search has failed; each further failure takes ten times more."""
    largest_regularization: float = 1e6
    penalty: float = 3e3
    """1/μ of the augmented Lagrangian iterations that may come first."""
    penalty_iterations: int = 15
    """Largest number of them."""
    penalty_sweeps: int = 3
    """Riccati sweeps on one linearisation of theirs."""
    penalty_tolerance: float = 1e-3
    """They end when no input changes by more than this, weighted by its cost."""


class Cddp:
    """CDDP with ProxQP in its backward and forward passes, after Xie, Liu and Hauser 2017.

    Everything but the quadratic programs that no guess of the active set solves runs in compiled kernels; they are
    compiled, or loaded from the cache on disk, in the constructor and never in a solve.

    Args:
        problem: The problem.
        options: Settings.
    """

    def __init__(self, problem: Problem, options: CddpOptions | None = None) -> None:
        self.problem = problem
        self.options = options or CddpOptions()
        self._work = Workspace.of(problem)
        self._model = problem.model
        self._qp = StageQpSolver(problem.nu, problem.n_constraints)
        self._forward_qp = StageQpSolver(problem.nu, problem.n_constraints)
        self.quadratic_programs = 0
        """Quadratic programs that ProxQP has solved so far."""
        self._compile()

    def solve(
        self,
        state: Array,
        inputs: Array,
        max_iterations: int,
        *,
        nominal_states: Array | None = None,
        gains: Array | None = None,
        active: NDArray[np.bool_] | None = None,
        accelerate: bool = False,
    ) -> Solution:
        """Improve a guess of the inputs.

        Args:
            state: First state, shape (nx,).
            inputs: First guess, shape (N, nu).
            max_iterations: Largest number of iterations; one linearises, sweeps back and rolls out.
            nominal_states: States, shape (N + 1, nx), and
            gains: feedback, shape (N, nu, nx), with which the guess is rolled out: u = U + K (x − X).
            active: First guess of the active rows at nodes 1 … N, shape (N, nh).
            accelerate: Begin with augmented Lagrangian iterations, which find the active set of the whole trajectory at
                once where CDDP loses one node an iteration; their result is rolled out onto dynamics and constraints.

        Returns:
            The solution; its status says whether it may be used.

        Raises:
            DimensionError: if an array has the wrong shape or is not finite.
        """
        started = time.perf_counter()
        self._set_guess(vector(state, self.problem.nx, "state"), inputs, nominal_states, gains)
        if active is not None and np.shape(active) != self._work.policy.active.shape:
            raise DimensionError(
                "wrong shape", field="active", given=np.shape(active), allowed=str(self._work.policy.active.shape)
            )
        self._work.policy.active[:] = False if active is None else active
        code = self._forward(1.0)
        status, iterations, cost = PlanStatus.ITERATION_LIMIT, 0, math.inf
        if code == backward_pass.DONE:
            self._accept()
            cost = float(self._work.scratch.result[0])
        if accelerate:
            iterations, cost = self._accelerate(cost, state, inputs, nominal_states, gains)
        if not math.isfinite(cost):
            return self._failure(code, iterations, started)
        while iterations < max_iterations:
            iterations += 1
            regularization, step, settled = 0.0, False, False
            backward_pass.linearize(self._model, self._work)
            while not (step or settled) and regularization <= self.options.largest_regularization:
                code, decrease = self._backward(regularization)
                if code == backward_pass.DONE:
                    settled = _LARGEST_RISE <= decrease / (1.0 + abs(cost)) <= self.options.tolerance
                    step = self._line_search(cost, decrease)
                    if settled and regularization == 0.0:  # regularisation makes any prediction small
                        status = PlanStatus.CONVERGED
                regularization = max(self.options.first_regularization, 10.0 * regularization)
            if step:
                self._accept()
                cost = float(self._work.scratch.result[0])
            if settled or not step:
                status = status if status is PlanStatus.CONVERGED else PlanStatus.STALLED
                break
        return self._solution(status, cost, iterations, started)

    def update_model(self, model: Any) -> None:
        """Take other parameters of the same model, without compiling.

        Args:
            model: NamedTuple of the problem's type.

        Raises:
            DimensionError: if it has another type.
        """
        if type(model) is not type(self._model):
            raise DimensionError("another type of model", field="model", given=type(model).__name__,
                                 allowed=type(self._model).__name__)  # fmt: skip
        self._model = model

    def _set_guess(self, state: Array, inputs: Array, states: Array | None, gains: Array | None) -> None:
        """Nominal trajectory and policy of the first rollout; its corrections are in the metric of the input weights."""
        work, nx = self._work, self.problem.nx
        _copy_checked("inputs", inputs, work.nominal.inputs)
        work.nominal.states[:] = 0.0
        if states is not None:
            _copy_checked("nominal_states", states, work.nominal.states)
        work.policy.gains[:] = 0.0
        if gains is not None:
            _copy_checked("gains", gains, work.policy.gains[:, :, :nx])
        work.policy.factors[:] = np.diag(np.sqrt(work.weights.input))
        work.policy.multipliers[:] = 0.0
        for array in work.trial:
            array[:] = np.nan  # so that what a failed rollout does not reach is not taken for its result
        work.trial.states[0] = state

    def _accelerate(
        self, cost: float, state: Array, inputs: Array, states: Array | None, gains: Array | None
    ) -> tuple[int, float]:
        """Augmented Lagrangian iterations, then a rollout of what they found; iterations and cost.

        They begin with the rollout or, where that got stuck at a constraint (`cost` is infinite), with the straight line
        to the goal, which need not satisfy the dynamics. If they lead nowhere better, the rollout is what it was.
        """
        work, options = self._work, self.options
        work.policy.multipliers[:] = 0.0
        if not math.isfinite(cost):
            part = np.linspace(0.0, 1.0, self.problem.horizon + 1)[:, None]
            work.nominal.states[:] = (1.0 - part) * np.asarray(state) + part * self.problem.cost.state_goal
            work.nominal.inputs[:] = inputs
        code = augmented_lagrangian.iterate(
            self._model,
            work,
            options.penalty,
            options.penalty_iterations,
            options.penalty_sweeps,
            options.penalty_tolerance,
        )
        iterations = int(work.scratch.result[1])
        if code != augmented_lagrangian.FAILED:
            work.trial.states[0] = state
            if self._forward(0.0) == backward_pass.DONE and work.scratch.result[0] < cost:
                self._accept()
                return iterations, float(work.scratch.result[0])
        self._set_guess(np.asarray(state, dtype=np.float64), inputs, states, gains)
        if self._forward(1.0) == backward_pass.DONE:
            self._accept()
        return iterations, cost

    def _line_search(self, cost: float, decrease: float) -> bool:
        """Roll out with shorter and shorter steps until the cost has fallen enough; False if it never does."""
        noise, decrease = 1e-13 * (1.0 + abs(cost)), max(decrease, 0.0)
        scale = 1.0
        while scale >= self.options.smallest_step:
            self._work.trial.states[0] = self._work.nominal.states[0]
            if self._forward(scale) == backward_pass.DONE:
                reached = self._work.scratch.result[0]
                if reached <= cost - self.options.sufficient_decrease * scale * decrease + noise:
                    return True
            scale *= 0.5
        return False

    def _backward(self, regularization: float) -> tuple[int, float]:
        """Backward pass; ProxQP where the kernel asks for it. Returns its code and the predicted decrease."""
        work = self._work
        terminal_value(work)
        node, settled = self.problem.horizon - 1, False
        while True:
            code = backward_pass.backward(work, node, regularization, self.options.guess_active_sets, settled)
            if code < 0:
                return code, float(work.scratch.result[2])
            self.quadratic_programs += 1
            if not self._qp.solve(work.qp):
                return backward_pass.NOT_CONVEX, 0.0
            threshold = 1e-9 * (1.0 + float(work.qp.multipliers.max()))
            work.policy.active[code] = work.qp.multipliers > threshold
            node, settled = code, True

    def _forward(self, scale: float) -> int:
        """Rollout; ProxQP where the kernel asks for it."""
        work = self._work
        node, corrections = 0, 0
        while True:
            code = forward_pass.forward(self._model, work, node, scale, self.options.guess_active_sets, corrections)
            if code < 0:
                return int(code)
            self.quadratic_programs += 1
            if not self._forward_qp.solve(work.qp):
                return int(forward_pass.NOT_FEASIBLE)
            corrections = corrections + 1 if code == node else 1
            node = code

    def _accept(self) -> None:
        self._work = self._work.swapped()

    def _solution(self, status: PlanStatus, cost: float, iterations: int, started: float) -> Solution:
        nominal, policy = self._work.nominal, self._work.policy
        reached = np.where(np.isnan(nominal.constraints), -np.inf, nominal.constraints)
        worst = int(np.argmax(reached)) if reached.size else 0
        node, row = divmod(worst, max(self.problem.n_constraints, 1))
        return Solution(
            states=_read_only(nominal.states),
            inputs=_read_only(nominal.inputs),
            gains=_read_only(policy.gains[:, :, : self.problem.nx]),
            multipliers=_read_only(policy.multipliers),
            cost=cost,
            max_violation=float(reached[node, row]) if reached.size else -math.inf,
            stationarity=float(self._work.scratch.result[3]),
            iterations=iterations,
            status=status,
            solve_time=time.perf_counter() - started,
            worst_node=node + 1,
            worst_constraint=row,
        )

    def _failure(self, code: int, iterations: int, started: float) -> Solution:
        """The rollout as far as it came, NaN from there on, with a status that forbids its use."""
        self._accept()
        status = PlanStatus.INFEASIBLE if code == forward_pass.NOT_FEASIBLE else PlanStatus.DIVERGED
        self._work.scratch.result[3] = math.inf
        solution = self._solution(status, math.inf, iterations, started)
        return solution if status is PlanStatus.INFEASIBLE else replace(solution, max_violation=math.inf)

    def _compile(self) -> None:
        """Run every kernel once."""
        cost = self.problem.cost
        self._set_guess(cost.state_goal.copy(), np.tile(cost.input_goal, (self.problem.horizon, 1)), None, None)
        forward_pass.forward(self._model, self._work, 0, 0.0, True, 0)
        self._accept()
        backward_pass.linearize(self._model, self._work)
        terminal_value(self._work)
        backward_pass.backward(self._work, self.problem.horizon - 1, 0.0, True, False)
        augmented_lagrangian.iterate(self._model, self._work, self.options.penalty, 1, 1, 0.0)
        for array in (self._work.nominal, self._work.trial):
            for field in array:
                field[:] = 0.0


def _copy_checked(field: str, values: Array, out: Array) -> None:
    given = np.asarray(values, dtype=np.float64)
    if given.shape != out.shape:
        raise DimensionError("wrong shape", field=field, given=given.shape, allowed=str(out.shape))
    if not np.isfinite(given).all():
        raise DimensionError("not finite", field=field, allowed="finite numbers")
    out[:] = given


def _read_only(array: Array) -> Array:
    copy = array.copy()
    copy.flags.writeable = False
    return copy
