"""RK4 steps of the Lagrangian model, with exact sensitivities. x is [Φ, α, Φ̇, α̇, H], u is [f_t, T, Ḣ_d]."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.dynamics.lagrangian_acceleration import (
    LagrangianMemory,
    LagrangianParameters,
    Number,
    Vector,
    lagrangian_accelerations,
    tip_in_body,
)
from doorman.dynamics.lagrangian_acceleration_jacobian import lagrangian_accelerations_jacobian, stage_motion
from doorman.numba_types.lanes import get, nan_beyond, put, zero

Array = NDArray[np.float64]


@kernel
def four(array: Array, first: int, lanes: Any) -> Any:
    """Four consecutive numbers of an array."""
    return (
        get(array, first, lanes),
        get(array, first + 1, lanes),
        get(array, first + 2, lanes),
        get(array, first + 3, lanes),
    )


@kernel
def ahead(a: Any, h: float, b: Any) -> Any:
    """Four numbers a + h b."""
    return a[0] + h * b[0], a[1] + h * b[1], a[2] + h * b[2], a[3] + h * b[3]


@kernel
def rk4_sum(a: Any, b: Any, c: Any, d: Any) -> Any:
    """Four numbers a + 2(b + c) + d."""
    return (
        a[0] + 2.0 * (b[0] + c[0]) + d[0],
        a[1] + 2.0 * (b[1] + c[1]) + d[1],
        a[2] + 2.0 * (b[2] + c[2]) + d[2],
        a[3] + 2.0 * (b[3] + c[3]) + d[3],
    )


@kernel
def tip_later(memory: LagrangianMemory, x: Array, u: Array, elapsed: float) -> Vector:
    """Position d of the tip `elapsed` seconds into the step: H moves at the rate that it is told."""
    lanes = memory.arm.lanes
    for j in range(memory.arm.joints.shape[0]):
        put(memory.angles, j, get(x, 8 + j, lanes) + elapsed * get(u, 4 + j, lanes))
    return tip_in_body(memory.arm, memory.angles)


@kernel
def lagrangian_derivative(p: LagrangianParameters, x: Array, u: Array, out: Array) -> None:
    """Derivative of `x` (8 + n,) under `u` (4 + n,) into `out` (8 + n,)."""
    tip = tip_in_body(p.memory.arm, x[8:])
    accelerations = lagrangian_accelerations(p, four(x, 0, ()), four(x, 4, ()), four(u, 0, ()), tip)
    for i in range(4):
        out[i] = x[4 + i]
        out[4 + i] = accelerations[i]
    for j in range(8, x.shape[0]):
        out[j] = u[j - 4]


@kernel
def lagrangian_contact_force(p: LagrangianParameters, x: Array, u: Array, out: Array) -> None:
    """Force w of the door on the tip, body axes, at `x` (8 + n,) under `u` (4 + n,) into `out` (3,)."""
    s = stage_motion(p, four(x, 0, ()), four(x, 4, ()), four(u, 0, ()), tip_in_body(p.memory.arm, x[8:]))
    out[0], out[1], out[2] = s.force


@kernel
def lagrangian_step(p: LagrangianParameters, x: Array, u: Array, out: Array) -> None:
    """One RK4 step: `out` (8 + n,) from `x` (8 + n,) and `u` (4 + n,); pitch is NaN where it leaves ±90°."""
    h = p.time_step
    q, v1, inputs = four(x, 0, ()), four(x, 4, ()), four(u, 0, ())
    a1 = lagrangian_accelerations(p, q, v1, inputs, tip_later(p.memory, x, u, 0.0))
    tip = tip_later(p.memory, x, u, 0.5 * h)
    v2 = ahead(v1, 0.5 * h, a1)
    a2 = lagrangian_accelerations(p, ahead(q, 0.5 * h, v1), v2, inputs, tip)
    v3 = ahead(v1, 0.5 * h, a2)
    a3 = lagrangian_accelerations(p, ahead(q, 0.5 * h, v2), v3, inputs, tip)
    v4 = ahead(v1, h, a3)
    a4 = lagrangian_accelerations(p, ahead(q, h, v3), v4, inputs, tip_later(p.memory, x, u, h))
    after, rates = ahead(q, h / 6.0, rk4_sum(v1, v2, v3, v4)), ahead(v1, h / 6.0, rk4_sum(a1, a2, a3, a4))
    for i in range(4):
        out[i] = after[i]
        out[4 + i] = rates[i]
    out[1] = nan_beyond(out[1], 0.5 * np.pi)  # the pole of the Euler angles: no state to go on with
    for j in range(8, x.shape[0]):
        out[j] = x[j] + h * u[j - 4]


@kernel
def linearize_stages(p: LagrangianParameters, memory: LagrangianMemory, x: Array, u: Array, out: Array) -> None:
    """The next [q, q̇] into column 0 of `out`, and the Jacobians of q̈ at the stages into `memory.jacobian`."""
    h, lanes = p.time_step, memory.arm.lanes
    q, v1, inputs = four(x, 0, lanes), four(x, 4, lanes), four(u, 0, lanes)
    a1 = lagrangian_accelerations_jacobian(p, memory, 0, q, v1, inputs, tip_later(memory, x, u, 0.0))
    tip = tip_later(memory, x, u, 0.5 * h)
    v2 = ahead(v1, 0.5 * h, a1)
    a2 = lagrangian_accelerations_jacobian(p, memory, 1, ahead(q, 0.5 * h, v1), v2, inputs, tip)
    v3 = ahead(v1, 0.5 * h, a2)
    a3 = lagrangian_accelerations_jacobian(p, memory, 2, ahead(q, 0.5 * h, v2), v3, inputs, tip)
    v4 = ahead(v1, h, a3)
    a4 = lagrangian_accelerations_jacobian(p, memory, 3, ahead(q, h, v3), v4, inputs, tip_later(memory, x, u, h))
    after, rates = ahead(q, h / 6.0, rk4_sum(v1, v2, v3, v4)), ahead(v1, h / 6.0, rk4_sum(a1, a2, a3, a4))
    for i in range(4):
        put(out, (i, 0), after[i])
        put(out, (4 + i, 0), rates[i])
    put(out, (1, 0), nan_beyond(get(out, (1, 0), lanes), 0.5 * np.pi))


@kernel
def slope(row: Array, lanes: Any, q: Any, v: Any) -> Number:
    """Inner product of the first eight numbers of a row with four and four."""
    a, b = four(row, 0, lanes), four(row, 4, lanes)
    return (a[0] * q[0] + a[1] * q[1] + a[2] * q[2] + a[3] * q[3]) + (
        b[0] * v[0] + b[1] * v[1] + b[2] * v[2] + b[3] * v[3]
    )


@kernel
def sensitivity_column(time_step: float, memory: LagrangianMemory, column: int, out: Array) -> None:
    """Derivative of the next [q, q̇] by one of [x, u] into its column of `out`, counted from 1, through the four stages.

    H is integrated exactly: at a stage its derivative is 1 by itself, and the time elapsed by Ḣ_d.
    """
    h, lanes, n, jacobian = time_step, memory.arm.lanes, memory.arm.joints.shape[0], memory.jacobian
    moves = column >= 12 + n
    forced = column - 4 - n if moves else column
    none = zero(lanes)
    q = (none + 1.0 * (column == 0), none + 1.0 * (column == 1), none + 1.0 * (column == 2), none + 1.0 * (column == 3))
    v = (none + 1.0 * (column == 4), none + 1.0 * (column == 5), none + 1.0 * (column == 6), none + 1.0 * (column == 7))
    a, b = q, v
    c, d = (none, none, none, none), (none, none, none, none)
    for level in range(4):
        weight = 1.0 if level == 0 or level == 3 else 2.0
        step = h if level == 2 else 0.5 * h
        rows = jacobian[level]
        rates = (
            slope(rows[0], lanes, a, b), slope(rows[1], lanes, a, b), slope(rows[2], lanes, a, b), slope(rows[3], lanes, a, b)
        )  # fmt: skip
        if column >= 8:
            share = (0.0 if level == 0 else (h if level == 3 else 0.5 * h)) if moves else 1.0
            forcing = (
                get(jacobian, (level, 0, forced), lanes), get(jacobian, (level, 1, forced), lanes),
                get(jacobian, (level, 2, forced), lanes), get(jacobian, (level, 3, forced), lanes),
            )  # fmt: skip
            rates = ahead(rates, share, forcing)
        c, d = ahead(c, weight, b), ahead(d, weight, rates)
        a, b = ahead(q, step, b), ahead(v, step, rates)
    q, v = ahead(q, h / 6.0, c), ahead(v, h / 6.0, d)
    for i in range(4):
        put(out, (i, 1 + column), q[i])
        put(out, (4 + i, 1 + column), v[i])


@kernel
def lagrangian_linearize(p: LagrangianParameters, memory: LagrangianMemory, x: Array, u: Array, out: Array) -> None:
    """One RK4 step of [q, q̇] with its sensitivities.

    Args:
        p: Parameters.
        memory: Its arm says whether there are lanes, a last axis of the arrays.
        x: Shape (8 + n,).
        u: Shape (4 + n,).
        out: The next [q, q̇], then its Jacobian by [x, u], shape (8, 13 + 2n).
    """
    linearize_stages(p, memory, x, u, out)
    for column in range(12 + 2 * memory.arm.joints.shape[0]):
        sensitivity_column(p.time_step, memory, column, out)


@kernel
def lagrangian_step_jacobian(p: LagrangianParameters, x: Array, u: Array, out: Array) -> None:
    """Jacobian [A | B] of `lagrangian_step` into `out` (8 + n, ≥ 12 + 2n); further columns are set to zero."""
    nx = x.shape[0]
    entries = p.memory.entries
    lagrangian_linearize(p, p.memory, x, u, entries)
    out[:, :] = 0.0
    for i in range(8):
        for j in range(entries.shape[1] - 1):
            out[i, j] = entries[i, 1 + j]
    for j in range(8, nx):
        out[j, j] = 1.0
        out[j, nx + j - 4] = p.time_step
