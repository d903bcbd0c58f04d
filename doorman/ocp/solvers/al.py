"""Augmented Lagrangian solver: the fast iterations by themselves, on the multiple-shooting form."""

from __future__ import annotations

import time

from doorman.ocp.solvers.engine import FAST_ITERATIONS
from doorman.ocp.solvers.iterations import augmented_lagrangian as kernels
from doorman.ocp.solvers.iterations import nominal
from doorman.ocp.solvers.iterations.careful import FIRST_PENALTY
from doorman.ocp.solvers.memory.result import RESULT
from doorman.ocp.solvers.solution import PlanStatus
from doorman.ocp.solvers.solver import Array, Solver

_STATUS = {
    kernels.CONVERGED: PlanStatus.CONVERGED,
    kernels.OUT_OF_ITERATIONS: PlanStatus.ITERATION_LIMIT,
    kernels.STALLED: PlanStatus.STALLED,
    kernels.FAILED: PlanStatus.DIVERGED,
}


class AugmentedLagrangian(Solver):
    """Semismooth augmented Lagrangian: fast iterations with a filter, then careful ones with a merit function.

    What it returns satisfies dynamics and constraints only as far as it has converged: a budget that ends early leaves defects
    and violations, and a status that forbids its use.
    """

    def _solve(self, state: Array, max_iterations: int, deadline: float) -> tuple[PlanStatus, int]:
        if not self._begin(state):
            return PlanStatus.INVALID_STATE, 0
        result = self._work.result
        code = self._teller.run(
            "fast",
            lambda: int(kernels.iterate(self._model, self._memory, min(max_iterations, FAST_ITERATIONS), deadline)),
            kernels.PAUSED,
        )
        iterations, penalty = int(result[RESULT.ITERATIONS]), float(result[RESULT.PENALTY])
        self._measure()
        if (code != kernels.CONVERGED or self._rough()) and iterations < max_iterations and time.monotonic() < deadline:
            if code != kernels.CONVERGED:
                self._guess_again()
                penalty = FIRST_PENALTY
            code = self._iterate_carefully(penalty, max_iterations - iterations, deadline)
            iterations += int(result[RESULT.ITERATIONS])
            self._measure()
        result[RESULT.COST] = nominal.nominal_cost(self._model, self._memory)
        return _STATUS[code], iterations

    def _judged(self, status: PlanStatus) -> PlanStatus:
        """What has not converged has not shown that its start can only be left through violations."""
        judged = super()._judged(status)
        unknown = judged is PlanStatus.RECOVERING and status is not PlanStatus.CONVERGED
        return PlanStatus.INFEASIBLE if unknown else judged

    def _measure(self) -> None:
        nominal.linearize(self._model, self._memory)
        nominal.measure_nominal(self._memory)

    def _rough(self) -> bool:
        """Whether the last step has left more than counts as feasible."""
        result = self._work.result
        return max(float(result[RESULT.VIOLATION]), float(result[RESULT.DEFECT])) > self.options.feasibility

    def _compile(self) -> None:
        super()._compile()
        kernels.iterate(self._model, self._memory, 1, 0.0)
        self._iterate_carefully(FIRST_PENALTY, 1, 0.0)
