"""ProxQP on one node's quadratic program: bounded in time, warm-started, with checked data.

The last bits of ProxQP's solution depend on where its memory lies, and so on the process. What is taken of it is therefore the
set of active rows; the solution that belongs to it is computed anew.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from proxsuite import proxqp

from doorman.ocp.solvers.memory.parts import Program

_LIMIT = 1e20
_ACCURACY = 1e-9
"""By which rows and multipliers of a solution that is computed anew may be wrong."""


class StageQpSolver:
    """Solver of min ½ vᵀHv + gᵀv subject to c + D v ≤ 0 for one size.

    Args:
        n_inputs: Length of v.
        n_constraints: Number of rows of D.
    """

    def __init__(self, n_inputs: int, n_constraints: int) -> None:
        self._arguments = n_inputs, n_constraints
        self._qp = proxqp.dense.QP(n_inputs, 0, n_constraints)
        settings = self._qp.settings
        settings.eps_abs = 1e-10
        settings.eps_rel = 0.0
        settings.eps_primal_inf = 1e-8  # its default, 1e-4, takes small rows for contradictions
        settings.max_iter = 40
        settings.max_iter_in = 30  # what needs more comes to nothing, after seconds
        settings.initial_guess = proxqp.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT
        self._lower = np.full(n_constraints, -_LIMIT)
        self._ready = False

    def __reduce__(self) -> tuple[Any, ...]:
        return StageQpSolver, self._arguments  # a copy has no last solution to start from

    def solve(self, program: Program) -> bool:
        """Solve; step and multipliers go into `program`."""
        data = (program.hessian, program.gradient, program.jacobian, program.constraints)
        if not all(np.isfinite(each).all() for each in data):
            return False  # NaN would keep the solver busy for seconds
        warm = self._ready
        if not self._attempt(program) and not (warm and self._attempt(program)):  # the last solution: a bad start
            return False
        if not self._solve_for_active_rows(program):
            program.step[:] = self._qp.results.x
            np.maximum(self._qp.results.z, 0.0, out=program.multipliers)
        return True

    def _solve_for_active_rows(self, program: Program) -> bool:
        """Solution with the rows that ProxQP has found active as equations; False if it is none."""
        n, slack = len(program.gradient), program.constraints + program.jacobian @ self._qp.results.x
        active = np.flatnonzero(self._qp.results.z > -slack)
        rows, size = program.jacobian[active], n + len(active)
        system = np.zeros((size, size))
        system[:n, :n], system[:n, n:], system[n:, :n] = program.hessian, rows.T, rows
        try:
            found = np.linalg.solve(system, -np.concatenate([program.gradient, program.constraints[active]]))
        except np.linalg.LinAlgError:
            return False
        step, multipliers = found[:n], found[n:]
        holds = (program.constraints + program.jacobian @ step <= _ACCURACY).all() and (multipliers >= -_ACCURACY).all()
        if not holds or not np.isfinite(found).all():
            return False
        program.step[:] = step
        program.multipliers[:] = 0.0
        program.multipliers[active] = np.maximum(multipliers, 0.0)
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
