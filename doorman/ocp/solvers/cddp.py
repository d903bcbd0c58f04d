"""Constrained differential dynamic programming: every iterate satisfies dynamics and nonlinear constraints."""

from __future__ import annotations

import time

from doorman.arrays import Array
from doorman.exceptions import SolverError
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.iterations import nominal
from doorman.ocp.solvers.options import SolverOptions
from doorman.ocp.solvers.solution import PlanStatus
from doorman.ocp.solvers.solver import Solver
from doorman.ocp.solvers.sweeps import backward as backward_pass
from doorman.ocp.solvers.sweeps.sweep import terminal_value


class Cddp(Solver):
    """CDDP with ProxQP in its backward and forward passes, after Xie, Liu and Hauser 2017.

    The first guess is rolled out inside the constraints; from then on every iterate is feasible, so that any may be the last.
    It takes no equalities: those of the end need the inputs of many nodes.
    """

    def __init__(self, problem: Problem, options: SolverOptions | None = None) -> None:
        if any(problem.equalities):
            raise SolverError(
                "this solver takes no equalities", field="problem.equalities", given=sum(problem.equalities),
                allowed="0, or Hybrid, which does",
            )  # fmt: skip
        super().__init__(problem, options)

    def _solve(self, state: Array, max_iterations: int, deadline: float) -> tuple[PlanStatus, int]:
        if not self._begin(state):
            return PlanStatus.INVALID_STATE, 0
        if not self._start():
            return PlanStatus.DIVERGED, 0
        return self._descend(max_iterations, deadline)

    def _descend(self, max_iterations: int, deadline: float) -> tuple[PlanStatus, int]:
        """Iterate from a rolled out trajectory: status and number of iterations."""
        result, options = self._work.result, self.options
        cost, iterations = result.cost, 0
        while iterations < max_iterations and time.monotonic() < deadline:
            iterations += 1
            regularization, stepped, settled, converged, late = 0.0, False, False, False, False
            outside = self._last_violated() >= 0
            nominal.linearize(self._model, self._memory)
            while not (stepped or settled or late) and regularization <= options.largest_regularization:
                if self._backward(regularization):
                    decrease = result.decrease
                    # rows that a rollout leaves violated by its tolerance may cost as much to restore
                    settled = -options.feasibility <= decrease / (1.0 + abs(cost)) <= options.tolerance
                    converged |= settled and regularization == 0.0  # regularisation makes any prediction small
                    stepped = self._line_search(cost, decrease, outside)
                late = time.monotonic() >= deadline
                regularization = max(options.first_regularization, 10.0 * regularization)
            if stepped:
                self._accept()
                cost = result.cost
                self._teller.tell("descent", iterations)
            if late:
                break
            if settled or not stepped:
                self._measure_nominal(cost)
                return (PlanStatus.CONVERGED if converged else PlanStatus.STALLED), iterations
        self._measure_nominal(cost)
        return PlanStatus.ITERATION_LIMIT, iterations

    def _measure_nominal(self, cost: float) -> None:
        """Measure the nominal trajectory, after trials that came to nothing."""
        self._measure()
        self._work.result.cost = cost

    def _line_search(self, cost: float, decrease: float, outside: bool) -> bool:
        """Roll out with shorter and shorter steps until the cost has fallen enough; False if it never does."""
        options, result = self.options, self._work.result
        noise, decrease = 1e-13 * (1.0 + abs(cost)), max(decrease, 0.0)
        scale = 1.0
        while scale >= options.smallest_step and time.monotonic() < self._deadline:
            if self._roll_out(scale):
                feasible = result.violation <= options.feasibility or outside
                if feasible and result.cost <= cost - options.sufficient_decrease * scale * decrease + noise:
                    return True
            scale *= 0.5
        return False

    def _backward(self, regularization: float) -> bool:
        """Backward pass; ProxQP where the kernel asks for it. False if some Q_uu is not positive definite."""
        work = self._work
        terminal_value(self._model, self._memory)
        work.result.change = 0.0
        node, settled = self._problem.horizon - 1, False
        while True:
            code = backward_pass.backward(self._model, self._memory, node, regularization, settled)
            if code < 0:
                return bool(code == backward_pass.DONE)
            if self._solve_program():
                threshold = 1e-9 * (1.0 + float(work.program.multipliers.max()))
                work.program.active[code] = work.program.multipliers > threshold
            else:
                work.program.active[code] = False  # no input is good enough: the rows of this node are passed over
            node, settled = code, True

    def _compile(self) -> None:
        super()._compile()
        nominal.linearize(self._model, self._memory)
        terminal_value(self._model, self._memory)
        backward_pass.backward(self._model, self._memory, self._problem.horizon - 1, 0.0, False)
