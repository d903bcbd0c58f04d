r"""The planner's simplified dynamics, integrated by RK4, with exact sensitivities (the paper's simplified dynamics).

.. math::
    \dot\Phi = W(\Phi)\,\Omega,\quad
    \ddot\alpha = -\frac{D_V f_t}{I_D}\,n_D^T R e_3
                  -\frac{b\dot\alpha + \tau_c\tanh(\dot\alpha/\epsilon) + k(\alpha-\alpha_0) + \tau_d}{I_D},\quad
    \dot H = \dot H_d

with :math:`n_D^T R e_3 = \cos\phi\sin\theta\sin(\alpha-\psi) + \sin\phi\cos(\alpha-\psi)`. The first five states do not
depend on H, and H is integrated exactly: only z = [Φ, α, α̇] with v = [f_t, Ω] goes through the stages of RK4.

Every formula is written once for numbers and for lanes (`doorman.numba_types.lanes`): one state, or many side by side.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.numba_types.lanes import get, nan_beyond, put, sincos, tanh

Array = NDArray[np.float64]
Number = Any
"""A float, or lanes."""

N_ENTRIES = 38
"""Numbers that one linearised step fills in: z⁺, and the entries of its Jacobian that are not constant."""

ENTRY_ROWS = (0, 1, 2, 3, 4) * 5 + (3, 4) * 4
ENTRY_COLUMNS = (0,) * 5 + (1,) * 5 + (-3,) * 5 + (-2,) * 5 + (-1,) * 5 + (2, 2, 3, 3, 4, 4, -4, -4)
"""Row and column in the Jacobian of entry 5 + i: a column of [Φ, α, α̇], or, counted back from −4, of [f_t, Ω]."""


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
    entries: Array
    """Scratch of `quasi_static_step_jacobian`, shape (N_ENTRIES,)."""


@kernel
def quasi_static_rates(
    p: QuasiStaticParameters,
    roll: Number,
    pitch: Number,
    yaw: Number,
    angle: Number,
    rate: Number,
    thrust: Number,
    wx: Number,
    wy: Number,
    wz: Number,
) -> tuple[Number, Number, Number, Number]:
    """Time derivatives of [φ, θ, ψ, α̇] (that of α is α̇ itself)."""
    sr, cr = sincos(roll)
    sp, cp = sincos(pitch)
    sd, cd = sincos(angle - yaw)
    yaw_rate = (sr * wy + cr * wz) / cp
    push = cr * sp * sd + sr * cd
    resistance = p.damping * rate + p.stiffness * (angle - p.rest_angle) + p.disturbance
    if p.friction > 0.0:
        resistance = resistance + p.friction * tanh(rate / p.friction_rate)
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
    out[1] = nan_beyond(x[1] + w * (b1 + 2.0 * (b2 + b3) + b4), 0.5 * np.pi)  # the pole of the Euler angles
    out[2] = x[2] + w * (c1 + 2.0 * (c2 + c3) + c4)
    out[3] = x[3] + w * (d1 + 2.0 * (d2 + d3) + d4)
    out[4] = x[4] + w * (e1 + 2.0 * (e2 + e3) + e4)
    for j in range(5, x.shape[0]):
        out[j] = x[j] + h * u[j - 1]


class Slopes(NamedTuple):
    """Derivative of z = [Φ, α, α̇] at one stage and what it changes with; named by row and column."""

    rates: tuple[Number, Number, Number, Number, Number]
    roll: tuple[Number, Number]
    """Of φ̇ by φ and θ."""
    pitch: Number
    """Of θ̇ by φ."""
    yaw: tuple[Number, Number]
    """Of ψ̇ by φ and θ."""
    door: tuple[Number, Number, Number, Number, Number]
    """Of α̈ by φ, θ, ψ, α and α̇."""
    inputs: tuple[Number, Number, Number, Number, Number, Number, Number]
    """Of φ̇, θ̇, ψ̇ by ω_y, the same by ω_z, and of α̈ by f_t."""


@kernel
def quasi_static_slopes(
    p: QuasiStaticParameters,
    z: tuple[Number, Number, Number, Number, Number],
    v: tuple[Number, Number, Number, Number],
) -> Slopes:
    """Derivative of z = [Φ, α, α̇] with inputs v = [f_t, Ω], and its slopes."""
    (roll, pitch, yaw, angle, rate), (f, wx, wy, wz) = z, v
    sr, cr = sincos(roll)
    sp, cp = sincos(pitch)
    sd, cd = sincos(angle - yaw)
    secant = 1.0 / cp
    yaw_rate = (sr * wy + cr * wz) * secant
    across = (cr * wy - sr * wz) * secant
    scale = p.distance_from_hinge / p.door_inertia
    push = cr * sp * sd + sr * cd
    resistance = p.damping * rate + p.stiffness * (angle - p.rest_angle) + p.disturbance
    by_rate = rate * 0.0 - p.damping
    if p.friction > 0.0:
        slip = tanh(rate / p.friction_rate)
        resistance = resistance + p.friction * slip
        by_rate = by_rate - p.friction * (1.0 - slip * slip) / p.friction_rate
    force = scale * f
    turn = force * (cr * sp * cd - sr * sd)
    return Slopes(
        rates=(
            wx + sp * yaw_rate,
            cr * wy - sr * wz,
            yaw_rate,
            rate + 0.0,
            -force * push - resistance / p.door_inertia,
        ),
        roll=(sp * across, yaw_rate * secant),
        pitch=-sr * wy - cr * wz,
        yaw=(across, yaw_rate * sp * secant),
        door=(
            -force * (cr * cd - sr * sp * sd),
            -force * cr * cp * sd,
            turn,
            -turn - p.stiffness / p.door_inertia,
            by_rate / p.door_inertia,
        ),
        inputs=(sr * sp * secant, cr, sr * secant, cr * sp * secant, -sr, cr * secant, -scale * push),
    )


@kernel
def _ahead(z: Any, h: float, rates: Any) -> Any:
    return (
        z[0] + h * rates[0],
        z[1] + h * rates[1],
        z[2] + h * rates[2],
        z[3] + h * rates[3],
        z[4] + h * rates[4],
    )


@kernel
def _attitude_column(
    h: float, stages: Any, roll: Number, pitch: Number, wx: Number, wy: Number, wz: Number
) -> tuple[Number, Number, Number, Number, Number]:
    """Change of z by one number of φ_0, θ_0 or Ω, the one of the five that is 1: of φ, θ, ψ, α, α̇ less those of z_0."""
    none = 0.0 * roll
    a, b, c, d, e = roll, pitch, none, none, none
    ta, tb, tc, td, te = none, none, none, none, none
    for level in range(4):
        s = stages[level]
        fa = s.roll[0] * a + s.roll[1] * b + wx + s.inputs[0] * wy + s.inputs[3] * wz
        fb = s.pitch * a + s.inputs[1] * wy + s.inputs[4] * wz
        fc = s.yaw[0] * a + s.yaw[1] * b + s.inputs[2] * wy + s.inputs[5] * wz
        fe = s.door[0] * a + s.door[1] * b + s.door[2] * c + s.door[3] * d + s.door[4] * e
        weight = 1.0 if level == 0 or level == 3 else 2.0
        ta, tb, tc, td, te = ta + weight * fa, tb + weight * fb, tc + weight * fc, td + weight * e, te + weight * fe
        q = h if level == 2 else 0.5 * h
        a, b, c, d, e = roll + q * fa, pitch + q * fb, q * fc, q * e, q * fe
    w = h / 6.0
    return w * ta, w * tb, w * tc, w * td, w * te


@kernel
def _door_column(
    h: float, stages: Any, yaw: Number, angle: Number, rate: Number, thrust: Number
) -> tuple[Number, Number]:
    """Change of α and α̇ by ψ_0, α_0, α̇_0 or f_t, the one of the four that is 1, less those of z_0."""
    d, e = angle, rate
    td, te = 0.0 * rate, 0.0 * rate
    for level in range(4):
        s = stages[level]
        fe = s.door[2] * yaw + s.door[3] * d + s.door[4] * e + s.inputs[6] * thrust
        weight = 1.0 if level == 0 or level == 3 else 2.0
        td, te = td + weight * e, te + weight * fe
        q = h if level == 2 else 0.5 * h
        d, e = angle + q * e, rate + q * fe
    return h / 6.0 * td, h / 6.0 * te


@kernel
def quasi_static_linearize(p: QuasiStaticParameters, x: Array, u: Array, lanes: Any, out: Array) -> None:
    """Next z and its Jacobian, as far as they are not constant, into `out`, in the order of `ENTRY_ROWS`.

    Args:
        p: Parameters.
        x: States, shape (5 + n,), or (5 + n, lanes).
        u: Inputs, shape (4 + n,), or (4 + n, lanes).
        lanes: Empty, or as long as there are lanes.
        out: Shape (`N_ENTRIES`,), or (`N_ENTRIES`, lanes).
    """
    h = p.time_step
    z = (get(x, 0, lanes), get(x, 1, lanes), get(x, 2, lanes), get(x, 3, lanes), get(x, 4, lanes))
    v = (get(u, 0, lanes), get(u, 1, lanes), get(u, 2, lanes), get(u, 3, lanes))
    first = quasi_static_slopes(p, z, v)
    second = quasi_static_slopes(p, _ahead(z, 0.5 * h, first.rates), v)
    third = quasi_static_slopes(p, _ahead(z, 0.5 * h, second.rates), v)
    fourth = quasi_static_slopes(p, _ahead(z, h, third.rates), v)
    stages = (first, second, third, fourth)
    none = 0.0 * z[0]
    one = none + 1.0
    w = h / 6.0
    for i in range(5):
        total = first.rates[i] + 2.0 * (second.rates[i] + third.rates[i]) + fourth.rates[i]
        put(out, i, z[i] + w * total)
    put(out, 1, nan_beyond(get(out, 1, lanes), 0.5 * np.pi))
    first_entry = 5
    for column in range(5):
        roll, pitch = one if column == 0 else none, one if column == 1 else none
        wx, wy, wz = one if column == 2 else none, one if column == 3 else none, one if column == 4 else none
        a, b, c, d, e = _attitude_column(h, stages, roll, pitch, wx, wy, wz)
        put(out, first_entry, a + roll)
        put(out, first_entry + 1, b + pitch)
        put(out, first_entry + 2, c)
        put(out, first_entry + 3, d)
        put(out, first_entry + 4, e)
        first_entry += 5
    for column in range(4):
        yaw, angle = one if column == 0 else none, one if column == 1 else none
        rate, thrust = one if column == 2 else none, one if column == 3 else none
        d, e = _door_column(h, stages, yaw, angle, rate, thrust)
        put(out, first_entry, d + angle)
        put(out, first_entry + 1, e + rate)
        first_entry += 2


@kernel
def quasi_static_step_jacobian(p: QuasiStaticParameters, x: Array, u: Array, out: Array) -> None:
    """Jacobian [A | B] of `quasi_static_step` into `out` (5 + n, ≥ 9 + 2n); further columns are set to zero."""
    nx = x.shape[0]
    quasi_static_linearize(p, x, u, (), p.entries)
    out[:, :] = 0.0
    out[2, 2] = 1.0  # nothing depends on ψ but α̈
    for i in range(len(ENTRY_ROWS)):
        column = ENTRY_COLUMNS[i]
        out[ENTRY_ROWS[i], column if column >= 0 else nx + 4 + column] = p.entries[5 + i]
    for i in range(5, nx):
        out[i, i] = 1.0
        out[i, nx + i - 1] = p.time_step
