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
    """τ_d, a further torque in the sense of damping, from an estimator [N m]."""
    state: Array
    """Scratch: z at one stage, shape (5,)."""
    rates: Array
    """Scratch: its derivative, shape (5,)."""
    stage: Array
    """Scratch: slopes of the derivative by the inputs, shape (5, 16), zero but for columns 5 … 8."""
    sensitivity: Array
    """Scratch: sensitivities of the present stage and the weighted sum of their derivatives, shape (2, 5, 16)."""


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
    slip = np.tanh(rate / p.friction_rate) if p.friction > 0.0 else 0.0
    resistance = p.damping * rate + p.friction * slip + p.stiffness * (angle - p.rest_angle) + p.disturbance
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
    if not abs(out[1]) < 0.5 * np.pi:
        out[1] = np.nan  # through the pole of the Euler angles: no state to go on with
    for j in range(5, x.shape[0]):
        out[j] = x[j] + h * u[j - 1]


@kernel
def quasi_static_linearize(
    p: QuasiStaticParameters, z: Array, f: float, wx: float, wy: float, wz: float
) -> tuple[float, float, float, float, float, float, float, float, float, float]:
    """Derivative of z = [Φ, α, α̇] into `p.rates`, its slopes by [f_t, Ω] into columns 5 … 8 of `p.stage`.

    Returns:
        Slopes by z: of φ̇ by φ and θ, of θ̇ by φ, of ψ̇ by φ and θ, of α̈ by φ, θ, ψ, α and α̇.
    """
    sr, cr, sp, cp = np.sin(z[0]), np.cos(z[0]), np.sin(z[1]), np.cos(z[1])
    sd, cd = np.sin(z[3] - z[2]), np.cos(z[3] - z[2])
    secant = 1.0 / cp
    yaw_rate = (sr * wy + cr * wz) * secant
    across = (cr * wy - sr * wz) * secant
    scale = p.distance_from_hinge / p.door_inertia
    push = cr * sp * sd + sr * cd
    slip = np.tanh(z[4] / p.friction_rate) if p.friction > 0.0 else 0.0
    resistance = p.damping * z[4] + p.friction * slip + p.stiffness * (z[3] - p.rest_angle) + p.disturbance
    rates, stage = p.rates, p.stage
    rates[0] = wx + sp * yaw_rate
    rates[1] = cr * wy - sr * wz
    rates[2] = yaw_rate
    rates[3] = z[4]
    rates[4] = -scale * f * push - resistance / p.door_inertia
    stage[0, 6] = 1.0
    stage[0, 7] = sr * sp * secant
    stage[0, 8] = cr * sp * secant
    stage[1, 7] = cr
    stage[1, 8] = -sr
    stage[2, 7] = sr * secant
    stage[2, 8] = cr * secant
    stage[4, 5] = -scale * push
    turn = scale * f * (cr * sp * cd - sr * sd)
    return (
        sp * across,
        yaw_rate * secant,
        -sr * wy - cr * wz,
        across,
        yaw_rate * sp * secant,
        -scale * f * (-sr * sp * sd + cr * cd),
        -scale * f * cr * cp * sd,
        turn,
        -turn - p.stiffness / p.door_inertia,
        -(p.damping + p.friction * (1.0 - slip * slip) / p.friction_rate) / p.door_inertia,
    )


@kernel
def quasi_static_step_jacobian(p: QuasiStaticParameters, x: Array, u: Array, out: Array) -> None:
    """Jacobian [A | B] of `quasi_static_step` into `out` (5 + n, ≥ 9 + 2n); further columns are set to zero.

    The sensitivities of z by [z_0, f_t, Ω] go through the stages as rows padded to 16, so that their loop is vectorised.
    """
    nx = x.shape[0]
    h = p.time_step
    s, total, stage, z, rates = p.sensitivity[0], p.sensitivity[1], p.stage, p.state, p.rates
    s[:, :] = 0.0
    total[:, :] = 0.0
    for i in range(5):
        s[i, i] = 1.0
        z[i] = x[i]
    for level in range(4):
        a0, a1, b0, c0, c1, e0, e1, e2, e3, e4 = quasi_static_linearize(p, z, u[0], u[1], u[2], u[3])
        weight = 1.0 if level == 0 or level == 3 else 2.0
        ahead = h if level == 2 else 0.5 * h
        for j in range(16):
            s0, s1, s2, s3, s4 = s[0, j], s[1, j], s[2, j], s[3, j], s[4, j]
            d0 = a0 * s0 + a1 * s1 + stage[0, j]
            d1 = b0 * s0 + stage[1, j]
            d2 = c0 * s0 + c1 * s1 + stage[2, j]
            d4 = e0 * s0 + e1 * s1 + e2 * s2 + e3 * s3 + e4 * s4 + stage[4, j]
            total[0, j] += weight * d0
            total[1, j] += weight * d1
            total[2, j] += weight * d2
            total[3, j] += weight * s4
            total[4, j] += weight * d4
            s[0, j] = ahead * d0
            s[1, j] = ahead * d1
            s[2, j] = ahead * d2
            s[3, j] = ahead * s4
            s[4, j] = ahead * d4
        for i in range(5):
            s[i, i] += 1.0
            z[i] = x[i] + ahead * rates[i]
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
