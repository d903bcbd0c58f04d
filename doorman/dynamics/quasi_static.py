r"""The planner's simplified dynamics, integrated by RK4, with exact sensitivities (the paper's simplified dynamics).

.. math::
    \dot\Phi = W(\Phi)\,\Omega,\quad
    \ddot\alpha = -\frac{D_V f_t}{I_D}\,n_D^T R e_3
                  -\frac{b\dot\alpha + \tau_c\tanh(\dot\alpha/\epsilon) + k(\alpha-\alpha_0) + \tau_d}{I_D},\quad
    \dot H = \dot H_d

with :math:`n_D^T R e_3 = \cos\phi\sin\theta\sin(\alpha-\psi) + \sin\phi\cos(\alpha-\psi)`. The first five states do not
depend on H, and H is integrated exactly: only z = [Φ, α, α̇] with v = [f_t, Ω] goes through the stages of RK4.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel

Array = NDArray[np.float64]


class QuasiStaticParameters(NamedTuple):
    """Numbers of the simplified dynamics, SI units."""

    time_step: float
    distance_from_hinge: float
    door_inertia: float
    damping: float
    friction: float
    friction_rate: float
    stiffness: float
    rest_angle: float
    disturbance: float
    """τ_d, a further torque against opening, from an estimator [N m]."""
    rates: Array
    """Scratch: derivatives of z at one stage, shape (5,)."""
    stage: Array
    """Scratch: derivative Jacobian entries at one stage, shape (5, 9)."""
    sensitivity: Array
    """Scratch: sensitivities of the present stage, of its derivative and their sum, shape (3, 5, 9)."""


@kernel
def quasi_static_rates(
    p: QuasiStaticParameters,
    roll: float,
    pitch: float,
    yaw: float,
    angle: float,
    rate: float,
    thrust: float,
    wx: float,
    wy: float,
    wz: float,
) -> tuple[float, float, float, float]:
    """Time derivatives of [φ, θ, ψ, α̇] (that of α is α̇ itself): four floats."""
    sr, cr, sp, cp = np.sin(roll), np.cos(roll), np.sin(pitch), np.cos(pitch)
    sd, cd = np.sin(angle - yaw), np.cos(angle - yaw)
    yaw_rate = (sr * wy + cr * wz) / cp
    push = cr * sp * sd + sr * cd
    resistance = (
        p.damping * rate
        + p.friction * np.tanh(rate / p.friction_rate)
        + p.stiffness * (angle - p.rest_angle)
        + p.disturbance
    )
    acceleration = -(p.distance_from_hinge * thrust * push + resistance) / p.door_inertia
    return wx + sp * yaw_rate, cr * wy - sr * wz, yaw_rate, acceleration


@kernel
def quasi_static_step(p: QuasiStaticParameters, x: Array, u: Array, out: Array) -> None:
    """One RK4 step: `out` (5 + n,) from `x` (5 + n,) and `u` (4 + n,)."""
    h = p.time_step
    f, wx, wy, wz = u[0], u[1], u[2], u[3]
    a1, b1, c1, e1 = quasi_static_rates(p, x[0], x[1], x[2], x[3], x[4], f, wx, wy, wz)
    d1 = x[4]
    q = 0.5 * h
    a2, b2, c2, e2 = quasi_static_rates(
        p, x[0] + q * a1, x[1] + q * b1, x[2] + q * c1, x[3] + q * d1, x[4] + q * e1, f, wx, wy, wz
    )
    d2 = x[4] + q * e1
    a3, b3, c3, e3 = quasi_static_rates(
        p, x[0] + q * a2, x[1] + q * b2, x[2] + q * c2, x[3] + q * d2, x[4] + q * e2, f, wx, wy, wz
    )
    d3 = x[4] + q * e2
    a4, b4, c4, e4 = quasi_static_rates(
        p, x[0] + h * a3, x[1] + h * b3, x[2] + h * c3, x[3] + h * d3, x[4] + h * e3, f, wx, wy, wz
    )
    d4 = x[4] + h * e3
    w = h / 6.0
    out[0] = x[0] + w * (a1 + 2.0 * (a2 + a3) + a4)
    out[1] = x[1] + w * (b1 + 2.0 * (b2 + b3) + b4)
    out[2] = x[2] + w * (c1 + 2.0 * (c2 + c3) + c4)
    out[3] = x[3] + w * (d1 + 2.0 * (d2 + d3) + d4)
    out[4] = x[4] + w * (e1 + 2.0 * (e2 + e3) + e4)
    for j in range(5, x.shape[0]):
        out[j] = x[j] + h * u[j - 1]


@kernel
def quasi_static_rates_jacobian(
    p: QuasiStaticParameters, z: Array, f: float, wx: float, wy: float, wz: float, rates: Array, jacobian: Array
) -> None:
    """Derivative of z = [Φ, α, α̇] into `rates` (5,) and its Jacobian by [z, f_t, Ω] into `jacobian` (5, 9)."""
    sr, cr, sp, cp = np.sin(z[0]), np.cos(z[0]), np.sin(z[1]), np.cos(z[1])
    sd, cd = np.sin(z[3] - z[2]), np.cos(z[3] - z[2])
    secant = 1.0 / cp
    tp = sp * secant
    yaw_rate = (sr * wy + cr * wz) * secant
    across = (cr * wy - sr * wz) * secant
    scale = p.distance_from_hinge / p.door_inertia
    push = cr * sp * sd + sr * cd
    slip = np.tanh(z[4] / p.friction_rate)
    resistance = p.damping * z[4] + p.friction * slip + p.stiffness * (z[3] - p.rest_angle) + p.disturbance
    rates[0] = wx + sp * yaw_rate
    rates[1] = cr * wy - sr * wz
    rates[2] = yaw_rate
    rates[3] = z[4]
    rates[4] = -scale * f * push - resistance / p.door_inertia
    jacobian[:, :] = 0.0
    jacobian[0, 0] = sp * across
    jacobian[0, 1] = yaw_rate * secant
    jacobian[0, 6] = 1.0
    jacobian[0, 7] = sr * tp
    jacobian[0, 8] = cr * tp
    jacobian[1, 0] = -sr * wy - cr * wz
    jacobian[1, 7] = cr
    jacobian[1, 8] = -sr
    jacobian[2, 0] = across
    jacobian[2, 1] = yaw_rate * tp
    jacobian[2, 7] = sr * secant
    jacobian[2, 8] = cr * secant
    jacobian[3, 4] = 1.0
    turn = scale * f * (cr * sp * cd - sr * sd)
    jacobian[4, 0] = -scale * f * (-sr * sp * sd + cr * cd)
    jacobian[4, 1] = -scale * f * cr * cp * sd
    jacobian[4, 2] = turn
    jacobian[4, 3] = -turn - p.stiffness / p.door_inertia
    jacobian[4, 4] = -(p.damping + p.friction * (1.0 - slip * slip) / p.friction_rate) / p.door_inertia
    jacobian[4, 5] = -scale * push


@kernel
def quasi_static_step_jacobian(p: QuasiStaticParameters, x: Array, u: Array, out: Array) -> None:
    """Jacobian [A | B] of `quasi_static_step` into `out` (5 + n, 9 + 2n)."""
    nx = x.shape[0]
    h = p.time_step
    z, s, d, total = p.rates, p.sensitivity[0], p.sensitivity[1], p.sensitivity[2]
    stage = p.stage
    step = np.empty(5)
    for i in range(5):
        step[i] = x[i]
    s[:, :] = 0.0
    total[:, :] = 0.0
    for i in range(5):
        s[i, i] = 1.0
    for level in range(4):
        quasi_static_rates_jacobian(p, step, u[0], u[1], u[2], u[3], z, stage)
        for i in range(5):  # d = ∂f/∂z · s + ∂f/∂v; row 2 of z (yaw) enters only α̈
            for j in range(9):
                d[i, j] = 0.0
            for m in range(5):
                if stage[i, m] != 0.0:
                    for j in range(9):
                        d[i, j] += stage[i, m] * s[m, j]
            for j in range(5, 9):
                d[i, j] += stage[i, j]
        weight = 1.0 if level == 0 or level == 3 else 2.0
        ahead = h if level == 2 else 0.5 * h
        for i in range(5):
            for j in range(9):
                total[i, j] += weight * d[i, j]
                s[i, j] = ahead * d[i, j]
            s[i, i] += 1.0
            step[i] = x[i] + ahead * z[i]
    out[:, :] = 0.0
    for i in range(5):
        for j in range(5):
            out[i, j] = h / 6.0 * total[i, j]
        out[i, i] += 1.0
        for j in range(4):
            out[i, nx + j] = h / 6.0 * total[i, 5 + j]
    for i in range(5, nx):
        out[i, i] = 1.0
        out[i, nx + i - 1] = h
