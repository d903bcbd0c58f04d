r"""Exact first derivatives of the coupled equations of motion.

The equations of motion are a residual :math:`g(z, \dot\nu) = 0`, linear in :math:`\dot\nu` with the mass matrix M; so
:math:`\partial\dot\nu/\partial z = -M^{-1}\,\partial g/\partial z` with one factorisation, and the chain rule leads on to
:math:`\ddot q` by [Φ, α, Φ̇, α̇, H, f_t, T].
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.dynamics.lagrangian_acceleration import (
    Directions,
    LagrangianMemory,
    LagrangianParameters,
    MassFactors,
    Number,
    Vector,
    body_accelerations,
    directions,
    euler_map,
    euler_map_inverse,
    euler_map_slopes,
    force_on_tip,
    mass_factors,
    rate_bias,
    solve_mass,
)
from doorman.kinematics.arm import point_derivative
from doorman.kinematics.vectors import combine, cross, dot, scale, transform
from doorman.numba_types.lanes import get, put, tanh

Array = NDArray[np.float64]


class Stage(NamedTuple):
    """Motion at one stage, with its accelerations."""

    angles: Directions
    factors: MassFactors
    tip: Vector
    euler_rates: Vector
    rates: Vector
    """Ω."""
    door_rate: Number
    force: Vector
    """w."""
    turning: Vector
    """Ω̇."""
    swinging: Number
    """α̈."""
    euler_accelerations: Vector
    """Φ̈."""


@kernel
def stage_motion(p: LagrangianParameters, q: Any, v: Any, inputs: Any, tip: Vector) -> Stage:
    """Everything that the derivatives need, at q, q̇ = v, [f_t, T] and d."""
    angles = directions(q[0], q[1], q[3] - q[2])
    factors = mass_factors(p, angles.tangent, tip)
    euler_rates = (v[0], v[1], v[2])
    rates = euler_map(angles, euler_rates)
    turning, swinging = body_accelerations(p, angles, factors, tip, rates, (q[3], v[3]), inputs)
    force = force_on_tip(p, angles, rates, v[3], inputs[0], tip, turning, swinging)
    accelerations = euler_map_inverse(angles, combine(1.0, turning, -1.0, rate_bias(angles, euler_rates)))
    return Stage(angles, factors, tip, euler_rates, rates, v[3], force, turning, swinging, accelerations)


@kernel
def put_vector(row: Array, v: Vector) -> None:
    """Write three numbers to the first places of a row."""
    put(row, 0, v[0])
    put(row, 1, v[1])
    put(row, 2, v[2])


@kernel
def get_vector(row: Array, lanes: Any) -> Vector:
    """The first three numbers of a row."""
    return get(row, 0, lanes), get(row, 1, lanes), get(row, 2, lanes)


@kernel
def put_change(memory: LagrangianMemory, column: int, moment: Vector, torque: Number) -> None:
    """−∂g of one column: moment on the vehicle, torque in the hinge."""
    put_vector(memory.changes[column, 0], moment)
    put(memory.changes, (column, 0, 3), torque)


@kernel
def from_force(p: LagrangianParameters, s: Stage, force: Vector) -> tuple[Vector, Number]:
    """Moment and torque from a change ∂w of the force."""
    return cross(s.tip, force), -p.distance_from_hinge * dot(s.angles.tangent, force)


@kernel
def from_rates(p: LagrangianParameters, s: Stage, change: Vector) -> tuple[Vector, Number]:
    """Moment and torque from a change of Ω."""
    swirl = combine(1.0, cross(change, cross(s.rates, s.tip)), 1.0, cross(s.rates, cross(change, s.tip)))
    moment, torque = from_force(p, s, scale(-p.mass, swirl))
    gyroscopic = combine(
        1.0, cross(change, transform(p.inertia, s.rates)), 1.0, cross(s.rates, transform(p.inertia, change))
    )
    return combine(1.0, moment, -1.0, gyroscopic), torque


@kernel
def from_turn(p: LagrangianParameters, s: Stage, turn: Vector) -> tuple[Vector, Number]:
    """Moment and torque from a small turn of the body at fixed Ω: the door's directions and the vertical turn in it."""
    reach = p.distance_from_hinge
    seen = combine(reach * s.swinging, s.angles.tangent, -reach * s.door_rate * s.door_rate, s.angles.leaf)
    seen = combine(p.mass, seen, p.mass * p.gravity, s.angles.vertical)
    moment, torque = from_force(p, s, cross(seen, turn))
    return moment, torque - reach * dot(cross(s.angles.tangent, turn), s.force)


@kernel
def prepare_attitude(memory: LagrangianMemory, s: Stage) -> None:
    """What a change of Φ̇ or Φ makes of Ω, into `memory.rates`, and of W⁻¹Φ̈ + bias, into the second half of `memory.changes`.

    Rows of `memory.rates`: W⁻¹'s columns (by φ̇, θ̇ and ψ̇), then the slopes of Ω = W⁻¹Φ̇ by φ and θ.
    """
    (sr, cr), (sp, cp) = s.angles.roll, s.angles.pitch
    a, b, c = s.euler_rates
    none = 0.0 * a
    rates, lost = memory.rates, memory.changes
    put_vector(rates[0], (none + 1.0, none, none))
    put_vector(rates[1], (none, cr, -sr))
    put_vector(rates[2], (-sp, sr * cp, cr * cp))
    by_roll, by_pitch = euler_map_slopes(s.angles, s.euler_rates)
    put_vector(rates[3], by_roll)
    put_vector(rates[4], by_pitch)
    bias = rate_bias(s.angles, s.euler_rates)
    lost_roll, lost_pitch = euler_map_slopes(s.angles, s.euler_accelerations)
    bias_by_pitch = (sp * b * c, -cr * sp * a * c - sr * cp * b * c, sr * sp * a * c - cr * cp * b * c)
    put_vector(lost[0, 1], combine(1.0, lost_roll, 1.0, (none, bias[2], -bias[1])))
    put_vector(lost[1, 1], combine(1.0, lost_pitch, 1.0, bias_by_pitch))
    put_vector(lost[4, 1], (none, -sr * b + cr * cp * c, -cr * b - sr * cp * c))
    put_vector(lost[5, 1], (-cp * c, -sr * a - sr * sp * c, -cr * a - cr * sp * c))
    put_vector(lost[6, 1], (-cp * b, cr * cp * a - sr * sp * b, -sr * cp * a - cr * sp * b))


@kernel
def change_attitude(p: LagrangianParameters, memory: LagrangianMemory, s: Stage) -> None:
    """Columns of φ, θ and Φ̇."""
    lanes = memory.arm.lanes
    for j in range(5):
        moment, torque = from_rates(p, s, get_vector(memory.rates[j], lanes))
        put_change(memory, 4 + j if j < 3 else j - 3, moment, torque)
    for j in range(2):
        moment, torque = from_turn(p, s, get_vector(memory.rates[j], lanes))
        moment = combine(1.0, moment, 1.0, get_vector(memory.changes[j, 0], lanes))
        put_change(memory, j, moment, torque + get(memory.changes, (j, 0, 3), lanes))


@kernel
def change_door(p: LagrangianParameters, memory: LagrangianMemory, s: Stage) -> None:
    """Columns of ψ and α, opposite but for the spring, and of α̇."""
    reach, leaf, rate = p.distance_from_hinge, s.angles.leaf, s.door_rate
    swing = combine(-p.mass * reach * s.swinging, leaf, -p.mass * reach * rate * rate, s.angles.tangent)
    moment, torque = from_force(p, s, swing)
    torque = torque + reach * dot(leaf, s.force)
    put_change(memory, 2, scale(-1.0, moment), -torque)
    put_change(memory, 3, moment, torque - p.stiffness)
    moment, torque = from_force(p, s, scale(-2.0 * p.mass * reach * rate, leaf))
    torque = torque - p.damping
    if p.friction > 0.0:
        slip = tanh(rate / p.friction_rate)
        torque = torque - p.friction * (1.0 - slip * slip) / p.friction_rate
    put_change(memory, 7, moment, torque)


@kernel
def change_arm_and_inputs(p: LagrangianParameters, memory: LagrangianMemory, s: Stage) -> None:
    """Columns of H, f_t and T."""
    n, tip = memory.arm.joints.shape[0], memory.arm.points.shape[0] - 1
    none = 0.0 * s.door_rate
    for j in range(n):
        moved = point_derivative(memory.arm, tip, j)
        swirl = combine(1.0, cross(s.turning, moved), 1.0, cross(s.rates, cross(s.rates, moved)))
        moment, torque = from_force(p, s, scale(-p.mass, swirl))
        put_change(memory, 8 + j, combine(1.0, moment, 1.0, cross(moved, s.force)), torque)
    moment, torque = from_force(p, s, (none, none, none - 1.0))
    put_change(memory, 8 + n, moment, torque)
    for j in range(3):
        put(memory.changes, (9 + n + j, 0, j), none + 1.0)  # its other places stay zero


@kernel
def solve_changes(memory: LagrangianMemory, s: Stage, level: int) -> None:
    """Jacobian of q̈ at a stage from the columns of changes."""
    changes, jacobian, lanes = memory.changes, memory.jacobian, memory.arm.lanes
    for column in range(changes.shape[0]):
        moment, torque = get_vector(changes[column, 0], lanes), get(changes, (column, 0, 3), lanes)
        turning, swinging = solve_mass(s.factors, moment, torque)
        turning = combine(1.0, turning, -1.0, get_vector(changes[column, 1], lanes))
        x, y, z = euler_map_inverse(s.angles, turning)
        put(jacobian, (level, 0, column), x)
        put(jacobian, (level, 1, column), y)
        put(jacobian, (level, 2, column), z)
        put(jacobian, (level, 3, column), swinging)


@kernel
def lagrangian_accelerations_jacobian(
    p: LagrangianParameters, memory: LagrangianMemory, level: int, q: Any, v: Any, inputs: Any, tip: Vector
) -> tuple[Number, Number, Number, Number]:
    """Accelerations q̈; their Jacobian by [x, f_t, T] goes to `memory.jacobian[level]`.

    The arm in `memory` has the joints of this posture.
    """
    s = stage_motion(p, q, v, inputs, tip)
    prepare_attitude(memory, s)
    change_attitude(p, memory, s)
    change_door(p, memory, s)
    change_arm_and_inputs(p, memory, s)
    solve_changes(memory, s, level)
    x, y, z = s.euler_accelerations
    return x, y, z, s.swinging
