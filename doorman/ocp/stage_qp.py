"""ProxQP on one node's quadratic program: bounded in time, warm-started, with checked data."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from proxsuite import proxqp

from doorman.ocp.workspace import Program

Array = NDArray[np.float64]

_LIMIT = 1e20


class StageQpSolver:
    """Solver of min ½ vᵀHv + gᵀv subject to c + D v ≤ 0 for one size.

    Args:
        n_inputs: Length of v.
        n_constraints: Number of rows of D.
        tolerance: Absolute tolerance on primal and dual residual.
    """

    def __init__(self, n_inputs: int, n_constraints: int, tolerance: float = 1e-10) -> None:
        self._qp = proxqp.dense.QP(n_inputs, 0, n_constraints)
        settings = self._qp.settings
        settings.eps_abs = tolerance
        settings.eps_rel = 0.0
        settings.eps_primal_inf = 1e-8  # its default, 1e-4, takes small rows for contradictions
        settings.max_iter = 40
        settings.max_iter_in = 30  # what needs more comes to nothing, after seconds
        settings.initial_guess = proxqp.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT
        self._lower = np.full(n_constraints, -_LIMIT)
        self._ready = False

    def solve(self, program: Program) -> bool:
        """Solve; step and multipliers go into `program`.

        Args:
            program: Data; `step` (v) and `multipliers` (λ ≥ 0) are written.

        Returns:
            False if the data are not finite, the rows contradict each other, or the iteration limit is reached.
        """
        data = (program.hessian, program.gradient, program.jacobian, program.constraints)
        if not all(np.isfinite(each).all() for each in data):
            return False  # NaN would keep the solver busy for seconds
        warm = self._ready
        if not self._attempt(program) and not (warm and self._attempt(program)):  # the last solution: a bad start
            return False
        program.step[:] = self._qp.results.x
        np.maximum(self._qp.results.z, 0.0, out=program.multipliers)
        return True

    def _attempt(self, program: Program) -> bool:
        """Solve from the last solution, or from scratch where there is none; a failure leaves none."""
        upper = np.minimum(-program.constraints, _LIMIT)
        data = (program.hessian, program.gradient, None, None, program.jacobian, self._lower, upper)
        if self._ready:
            self._qp.update(*data)
        else:
            self._qp.init(*data)
        self._qp.solve()
        self._ready = self._qp.results.info.status == proxqp.QPSolverOutput.PROXQP_SOLVED
        if not self._ready:
            self._qp.cleanup()
        return self._ready
