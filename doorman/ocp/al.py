"""Augmented Lagrangian solver: the fast iterations by themselves, on the multiple-shooting form."""

from __future__ import annotations

from doorman.ocp import augmented_lagrangian as kernels
from doorman.ocp.solution import PlanStatus, Solution
from doorman.ocp.solver import Solver
from doorman.ocp.workspace import RESULT


class AugmentedLagrangian(Solver):
    """Semismooth augmented Lagrangian with Riccati sweeps and a filter line search, see `augmented_lagrangian`.

    What it returns satisfies dynamics and constraints only as far as it has converged: a budget that ends early leaves defects
    and violations, and a status that forbids its use.
    """

    def _solve(self, started: float, max_iterations: int, deadline: float) -> Solution:
        result, iterations, code = self._work.result, 0, kernels.CONVERGED
        violated = True
        while violated and code == kernels.CONVERGED and iterations < max_iterations:
            code = kernels.iterate(self._model, self._memory, max_iterations - iterations, deadline)
            iterations += int(result[RESULT.ITERATIONS])
            kernels.linearize(self._model, self._memory)
            kernels.measure_nominal(self._memory)
            violated = max(result[RESULT.VIOLATION], result[RESULT.DEFECT]) > self.options.feasibility
        result[RESULT.COST] = kernels.nominal_cost(self._model, self._memory)
        status = {
            kernels.CONVERGED: PlanStatus.CONVERGED,
            kernels.OUT_OF_ITERATIONS: PlanStatus.ITERATION_LIMIT,
            kernels.STALLED: PlanStatus.STALLED,
            kernels.FAILED: PlanStatus.DIVERGED,
        }[code]
        return self._finish(status, iterations, started)

    def _compile(self) -> None:
        super()._compile()
        kernels.iterate(self._model, self._memory, 1, 0.0)
