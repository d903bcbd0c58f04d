r"""Sequential quadratic programming on :math:`\min_z \max_i r_i(z)` over a box, in a trust region."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import proxsuite

from doorman.arrays import Array

_LARGEST_STEP = 0.3
_SMALLEST_STEP = 1e-5
_REGULARISATION = 1e-3
_ITERATIONS = 40


def minimise_largest(
    values: Callable[[Array], Array],
    slopes: Callable[[Array], Array],
    point: Array,
    lower: Array,
    upper: Array,
    smallest_gain: float = 1e-6,
) -> tuple[Array, float]:
    """Local minimiser of the largest of some functions."""
    r, step = values(point), _LARGEST_STEP
    for _ in range(_ITERATIONS):
        low, high = np.maximum(lower - point, -step), np.minimum(upper - point, step)
        jacobian = slopes(point)
        change = _minimax_step(r, jacobian, np.minimum(low, 0.0), np.maximum(high, 0.0))
        candidate = point + change
        reached = values(candidate)
        expected, gain = r.max() - (r + jacobian @ change).max(), r.max() - reached.max()
        if gain > 0.0:
            point, r = candidate, reached
        if expected < smallest_gain or step < _SMALLEST_STEP:
            break
        if gain < 0.25 * expected:
            step *= 0.4
        elif gain > 0.7 * expected:
            step = min(2.0 * step, _LARGEST_STEP)
    return point, float(r.max())


def _minimax_step(r: Array, jacobian: Array, low: Array, high: Array) -> Array:
    """Minimiser of max_i (r + J δ)_i over low ≤ δ ≤ high, slightly regularised; in variables of order one."""
    m, n = jacobian.shape
    step = max(float(high.max()), -float(low.min()), 1e-12)
    scale = max(step * float(np.abs(jacobian).sum(axis=1).max()), 1e-12)
    rows = np.zeros((m + n, n + 1))
    rows[:m, :n], rows[:m, n] = jacobian * (step / scale), -1.0
    rows[m:, :n] = np.eye(n)
    problem = proxsuite.proxqp.dense.QP(n + 1, 0, m + n)
    problem.settings.eps_abs = 1e-9
    problem.settings.eps_primal_inf = problem.settings.eps_dual_inf = 1e-14  # it is feasible: δ = 0 always is
    problem.settings.max_iter = problem.settings.max_iter_in = 200
    problem.init(
        _REGULARISATION * np.eye(n + 1), np.array([*[0.0] * n, 1.0]), None, None, rows,
        np.concatenate([np.full(m, -1e20), low / step]), np.concatenate([(r.max() - r) / scale, high / step]),
    )  # fmt: skip
    problem.solve()
    return np.asarray(np.clip(step * problem.results.x[:n], low, high))
