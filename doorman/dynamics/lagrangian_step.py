"""RK4 steps of the Lagrangian model, with exact sensitivities. x is [Φ, α, Φ̇, α̇, H], u is [f_t, T, Ḣ_d]."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.dynamics.lagrangian_acceleration import LagrangianParameters, lagrangian_accelerations
from doorman.dynamics.lagrangian_acceleration_jacobian import lagrangian_accelerations_jacobian

Array = NDArray[np.float64]


@kernel
def lagrangian_derivative(p: LagrangianParameters, x: Array, u: Array, out: Array) -> None:
    """Derivative of `x` (8 + n,) under `u` (4 + n,) into `out` (8 + n,)."""
    lagrangian_accelerations(p, x, u)
    for i in range(4):
        out[i] = x[4 + i]
        out[4 + i] = p.accelerations[i, 0]
    for j in range(8, x.shape[0]):
        out[j] = u[j - 4]


@kernel
def lagrangian_step(p: LagrangianParameters, x: Array, u: Array, out: Array) -> None:
    """One RK4 step: `out` (8 + n,) from `x` (8 + n,) and `u` (4 + n,); pitch is NaN where it leaves ±90°."""
    h = p.time_step
    stage, rates = p.stage[0], p.stage[1]
    for i in range(x.shape[0]):
        stage[i] = x[i]
        out[i] = x[i]
    for level in range(4):
        lagrangian_derivative(p, stage, u, rates)
        weight = h / 6.0 if level == 0 or level == 3 else h / 3.0
        ahead = h if level == 2 else 0.5 * h
        for i in range(x.shape[0]):
            out[i] += weight * rates[i]
            stage[i] = x[i] + ahead * rates[i]
    if not abs(out[1]) < 0.5 * np.pi:
        out[1] = np.nan  # through the pole of the Euler angles: no state to go on with


@kernel
def stage_sensitivity(p: LagrangianParameters, elapsed: float) -> None:
    """Sensitivity of the derivative of [Φ, α, Φ̇, α̇] at a stage `elapsed` seconds into the step.

    Reads the stage's own sensitivity in `p.sensitivity[0]` and the Jacobian of q̈ in `p.stage_jacobian`, writes
    `p.sensitivity[1]`. H is integrated exactly: its sensitivity is the identity by H and `elapsed` by Ḣ_d.
    """
    s, d, jacobian = p.sensitivity[0], p.sensitivity[1], p.stage_jacobian
    n = p.arm.joints.shape[0]
    for i in range(4):
        for j in range(12 + 2 * n):
            d[i, j] = s[4 + i, j]
            d[4 + i, j] = 0.0
        for m in range(8):
            for j in range(12 + 2 * n):
                d[4 + i, j] += jacobian[i, m] * s[m, j]
        for j in range(4):
            d[4 + i, 8 + n + j] += jacobian[i, 8 + n + j]
        for j in range(n):
            d[4 + i, 8 + j] += jacobian[i, 8 + j]
            d[4 + i, 12 + n + j] += elapsed * jacobian[i, 8 + j]


@kernel
def lagrangian_step_jacobian(p: LagrangianParameters, x: Array, u: Array, out: Array) -> None:
    """Jacobian [A | B] of `lagrangian_step` into `out` (8 + n, ≥ 12 + 2n); further columns are set to zero."""
    nx, h = x.shape[0], p.time_step
    stage, s, d, total = p.stage[0], p.sensitivity[0], p.sensitivity[1], p.sensitivity[2]
    stage[:] = x
    s[:, :] = 0.0
    total[:, :] = 0.0
    for i in range(8):
        s[i, i] = 1.0
    elapsed = 0.0
    for level in range(4):
        lagrangian_accelerations_jacobian(p, stage, u, p.stage_jacobian)
        stage_sensitivity(p, elapsed)
        weight = h / 6.0 if level == 0 or level == 3 else h / 3.0
        elapsed = h if level == 2 else 0.5 * h
        for i in range(4):
            rate = stage[4 + i]
            stage[i] = x[i] + elapsed * rate
        for i in range(4):
            stage[4 + i] = x[4 + i] + elapsed * p.accelerations[i, 0]
        for j in range(8, nx):
            stage[j] = x[j] + elapsed * u[j - 4]
        for i in range(8):
            for j in range(total.shape[1]):
                total[i, j] += weight * d[i, j]
                s[i, j] = elapsed * d[i, j]
            s[i, i] += 1.0
    out[:, :] = 0.0
    for i in range(8):
        for j in range(total.shape[1]):
            out[i, j] = total[i, j]
    for i in range(nx):
        out[i, i] += 1.0
    for j in range(8, nx):
        out[j, nx + j - 4] = h
