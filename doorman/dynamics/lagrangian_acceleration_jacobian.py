r"""Exact first derivatives of the coupled equations of motion.

The equations of motion are a residual :math:`g(z, \dot\nu) = 0`, linear in :math:`\dot\nu` with the mass matrix M; so
:math:`\partial\dot\nu/\partial z = -M^{-1}\,\partial g/\partial z` with one factorisation, and the chain rule leads on to
:math:`\ddot q` by [Φ, α, Φ̇, α̇, H, f_t, T].
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.dynamics.lagrangian_acceleration import (
    Angles,
    LagrangianParameters,
    body_accelerations,
    body_rates,
    directions_in_body,
    euler_accelerations,
    euler_map,
    euler_map_inverse,
    force_on_tip,
    rate_bias,
    sines_and_cosines,
    substitute,
    tip_in_body,
)
from doorman.kinematics.arm import point_derivative
from doorman.kinematics.vectors import Vector, combine, cross, dot, scale, transform, unit

Array = NDArray[np.float64]


@kernel
def put(p: LagrangianParameters, column: int, tangent: Vector, tip: Vector, force: Vector, rest: Vector) -> None:
    """Column of −∂g from ∂w in `force` and what is left of the rotational rows in `rest`."""
    moment = cross(tip, force)
    for i in range(3):
        p.partials[i, column] = moment[i] + rest[i]
    p.partials[3, column] = -p.distance_from_hinge * dot(tangent, force)


@kernel
def put_configuration(p: LagrangianParameters, angles: Angles, x: Array, tip: Vector, force: Vector) -> None:
    """Columns of Φ (at fixed Ω) and α: the door's directions turn in the body, and the vertical with them."""
    leaf, tangent, vertical = directions_in_body(angles)
    reach, mass = p.distance_from_hinge, p.mass
    rate, acceleration = x[7], p.accelerations[3, 0]
    zero = (0.0, 0.0, 0.0)
    turning = combine(reach * acceleration, tangent, -reach * rate * rate, leaf)
    turning = combine(mass, turning, mass * p.gravity, vertical)
    for j in range(3):
        turn = euler_map(angles, unit(j))[0]
        put(p, j, tangent, tip, cross(turning, turn), zero)
        p.partials[3, j] -= reach * dot(cross(tangent, turn), force)
    swing = combine(-mass * reach * acceleration, leaf, -mass * reach * rate * rate, tangent)
    put(p, 3, tangent, tip, swing, zero)
    p.partials[3, 3] += reach * dot(leaf, force) - p.stiffness


@kernel
def put_velocities(p: LagrangianParameters, angles: Angles, x: Array, tip: Vector) -> None:
    """Columns of Ω and α̇."""
    leaf, tangent, _ = directions_in_body(angles)
    rates = body_rates(angles, x)
    momentum = transform(p.inertia, rates)
    for j in range(3):
        axis = unit(j)
        swirl = combine(1.0, cross(axis, cross(rates, tip)), 1.0, cross(rates, cross(axis, tip)))
        gyroscopic = combine(-1.0, cross(axis, momentum), -1.0, cross(rates, transform(p.inertia, axis)))
        put(p, 4 + j, tangent, tip, scale(-p.mass, swirl), gyroscopic)
    swing = -2.0 * p.mass * p.distance_from_hinge * x[7]
    put(p, 7, tangent, tip, scale(swing, leaf), (0.0, 0.0, 0.0))
    slip = np.tanh(x[7] / p.friction_rate)
    p.partials[3, 7] -= p.damping + p.friction * (1.0 - slip * slip) / p.friction_rate


@kernel
def put_tip_and_inputs(p: LagrangianParameters, angles: Angles, x: Array, tip: Vector, force: Vector) -> None:
    """Columns of d, f_t and T."""
    tangent = directions_in_body(angles)[1]
    rates = body_rates(angles, x)
    turning = (p.accelerations[0, 0], p.accelerations[1, 0], p.accelerations[2, 0])
    zero = (0.0, 0.0, 0.0)
    for j in range(3):
        axis = unit(j)
        swirl = combine(1.0, cross(turning, axis), 1.0, cross(rates, cross(rates, axis)))
        put(p, 8 + j, tangent, tip, scale(-p.mass, swirl), cross(axis, force))
        put(p, 12 + j, tangent, tip, zero, axis)
    put(p, 11, tangent, tip, (0.0, 0.0, -1.0), zero)


@kernel
def chain_to_euler(p: LagrangianParameters, angles: Angles, x: Array, jacobian: Array) -> None:
    """Derivatives of ν̇ in `p.partials` to those of [Ω̇ − bias, α̈] by [Φ, α, Φ̇, α̇, H, f_t, T], Ω and d eliminated."""
    n, tip = p.arm.joints.shape[0], p.arm.points.shape[0] - 1
    _, by_roll, by_pitch = euler_map(angles, (x[4], x[5], x[6]))
    for i in range(4):
        row = p.partials[i]
        of_rates = (row[4], row[5], row[6])
        of_tip = (row[8], row[9], row[10])
        jacobian[i, 0] = row[0] + dot(of_rates, by_roll)
        jacobian[i, 1] = row[1] + dot(of_rates, by_pitch)
        jacobian[i, 2], jacobian[i, 3], jacobian[i, 7] = row[2], row[3], row[7]
        for j in range(3):
            jacobian[i, 4 + j] = dot(of_rates, euler_map(angles, unit(j))[0])
        for j in range(n):
            jacobian[i, 8 + j] = dot(of_tip, point_derivative(p.arm, tip, j))
        for j in range(4):
            jacobian[i, 8 + n + j] = row[11 + j]


@kernel
def subtract_bias(angles: Angles, x: Array, jacobian: Array) -> None:
    """Take the derivatives of the bias of Ω̇ = W⁻¹Φ̈ + bias, a quadratic form of Φ̇, off the rotational rows."""
    a, b, c = x[4], x[5], x[6]
    sr, cr, sp, cp, _, _ = angles
    bias = rate_bias(angles, x)
    jacobian[1, 0] -= bias[2]
    jacobian[2, 0] += bias[1]
    jacobian[0, 1] -= sp * b * c
    jacobian[1, 1] += cr * sp * a * c + sr * cp * b * c
    jacobian[2, 1] -= sr * sp * a * c - cr * cp * b * c
    jacobian[1, 4] -= -sr * b + cr * cp * c
    jacobian[2, 4] -= -cr * b - sr * cp * c
    jacobian[0, 5] += cp * c
    jacobian[1, 5] += sr * a + sr * sp * c
    jacobian[2, 5] += cr * a + cr * sp * c
    jacobian[0, 6] += cp * b
    jacobian[1, 6] -= cr * cp * a - sr * sp * b
    jacobian[2, 6] += sr * cp * a + cr * sp * b


@kernel
def lagrangian_accelerations_jacobian(p: LagrangianParameters, x: Array, u: Array, jacobian: Array) -> None:
    """q̈ into `p.accelerations` and its Jacobian by [x, f_t, T] into `jacobian` (4, 12 + n)."""
    angles = sines_and_cosines(x)
    tip = tip_in_body(p, x)
    body_accelerations(p, angles, x, u, tip)
    force = force_on_tip(p, angles, x, u[0], tip, p.accelerations)
    put_configuration(p, angles, x, tip, force)
    put_velocities(p, angles, x, tip)
    put_tip_and_inputs(p, angles, x, tip, force)
    substitute(p.mass_matrix, p.partials)
    chain_to_euler(p, angles, x, jacobian)
    subtract_bias(angles, x, jacobian)
    euler_accelerations(p, angles, x)
    q = p.accelerations
    _, by_roll, by_pitch = euler_map(angles, (q[0, 0], q[1, 0], q[2, 0]))
    for i in range(3):
        jacobian[i, 0] -= by_roll[i]
        jacobian[i, 1] -= by_pitch[i]
    for j in range(jacobian.shape[1]):
        value = euler_map_inverse(angles, (jacobian[0, j], jacobian[1, j], jacobian[2, j]))
        for i in range(3):
            jacobian[i, j] = value[i]
