r"""Kernels of the coupled equations of motion of vehicle and door (the paper's Lagrangian model).

With :math:`\nu = [\Omega,\ \dot\alpha]`, the leaf's direction c, its tangent s and the vertical k in body axes, the
acceleration of O_B and the force of the door on the tip are

.. math::
    a = D_V(\ddot\alpha\,s - \dot\alpha^2 c) + d\times\dot\Omega - \Omega\times(\Omega\times d),\quad
    w = m_A a - f_t e_3 + m_A g\,k

and the equations of motion, the Lagrange equations of q = [Φ, α] multiplied by :math:`[W^T, 1]`, are

.. math::
    I_A\dot\Omega + \Omega\times I_A\Omega = T + d\times w,\quad
    I_D\ddot\alpha = -D_V\,s^T w - (b\dot\alpha + \tau_c\tanh(\dot\alpha/\epsilon) + k(\alpha-\alpha_0) + \tau_d).

Their mass matrix is :math:`\begin{bmatrix} I_A + m_A(d^Td - dd^T) & g\\ g^T & I_D + m_A D_V^2\end{bmatrix}` with
:math:`g = m_A D_V\,s\times d`; its last pivot is constant, so that only a 3 × 3 matrix is left to invert.

The arm is locked within them, as in the paper ("a sufficiently slow servomotor speed"): d enters, its rate does not.

Every formula is written once for numbers and for lanes (`doorman.lanes`): one state, or many side by side.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.kinematics.arm import ArmParameters, arm_kinematics
from doorman.kinematics.vectors import combine, cross, dot, transform
from doorman.numba_types.lanes import get, sincos, tanh

Array = NDArray[np.float64]
Number = Any
"""A float, or lanes."""
Vector = tuple[Number, Number, Number]


class LagrangianMemory(NamedTuple):
    """The arm, and what kernels write to; arrays have a further, last axis of lanes where the arm has one."""

    arm: ArmParameters
    angles: Array
    """H at one stage, shape (n,)."""
    jacobian: Array
    """Jacobian of q̈ by [x, f_t, T] at the four stages, shape (4, 4, 12 + n)."""
    rates: Array
    """Changes of Ω, see `prepare_attitude`, shape (5, 3)."""
    changes: Array
    """For [x, f_t, T]: change of moment and torque, and of W⁻¹Φ̈ and its bias, shape (12 + n, 2, 4)."""
    entries: Array
    """Of `lagrangian_step_jacobian`: the next [q, q̇], then its Jacobian by [x, u], shape (8, 13 + 2n)."""


class LagrangianParameters(NamedTuple):
    """Numbers of the Lagrangian model, SI units; states x = [Φ, α, Φ̇, α̇, H], inputs u = [f_t, T, Ḣ_d]."""

    time_step: float
    mass: float
    gravity: float
    inertia: Array
    """I_A about O_B in body axes, shape (3, 3)."""
    distance_from_hinge: float
    door_inertia: float
    damping: float
    friction: float
    friction_rate: float
    stiffness: float
    rest_angle: float
    disturbance: float
    """τ_d, a further torque in the sense of damping, from an estimator [N m]."""
    memory: LagrangianMemory
    """For one state at a time."""


class Directions(NamedTuple):
    """Sine and cosine of roll, pitch and α − ψ, and what follows from them: directions in body axes."""

    roll: tuple[Number, Number]
    pitch: tuple[Number, Number]
    leaf: Vector
    """c = Rᵀ[cos α, sin α, 0]."""
    tangent: Vector
    """s = Rᵀ[−sin α, cos α, 0]."""
    vertical: Vector
    """k = Rᵀe₃."""


class MassFactors(NamedTuple):
    """The mass matrix of ν, inverted in blocks."""

    inverse: tuple[Number, Number, Number, Number, Number, Number]
    """Of the 3 × 3 matrix that is left of the rotation: xx, xy, xz, yy, yz, zz."""
    gain: Vector
    """m_A D_V s × d over I_D + m_A D_V²."""
    swing: float
    """1/(I_D + m_A D_V²)."""


@kernel
def directions(roll: Number, pitch: Number, turn: Number) -> Directions:
    """Directions in the body; `turn` is α − ψ, the only way in which these two angles enter."""
    sr, cr = sincos(roll)
    sp, cp = sincos(pitch)
    sd, cd = sincos(turn)
    leaf = (cp * cd, cr * sd + sr * sp * cd, -sr * sd + cr * sp * cd)
    tangent = (-cp * sd, cr * cd - sr * sp * sd, -sr * cd - cr * sp * sd)
    return Directions((sr, cr), (sp, cp), leaf, tangent, (-sp, sr * cp, cr * cp))


@kernel
def euler_map(angles: Directions, v: Vector) -> Vector:
    """W⁻¹v: Euler rates to body rates."""
    (sr, cr), (sp, cp) = angles.roll, angles.pitch
    return v[0] - sp * v[2], cr * v[1] + sr * cp * v[2], -sr * v[1] + cr * cp * v[2]


@kernel
def euler_map_slopes(angles: Directions, v: Vector) -> tuple[Vector, Vector]:
    """Derivatives of W⁻¹v by roll and pitch."""
    (sr, cr), (sp, cp) = angles.roll, angles.pitch
    none = 0.0 * sr
    by_roll = (none, -sr * v[1] + cr * cp * v[2], -cr * v[1] - sr * cp * v[2])
    return by_roll, (-cp * v[2], -sr * sp * v[2], -cr * sp * v[2])


@kernel
def euler_map_inverse(angles: Directions, v: Vector) -> Vector:
    """W v: body rates to Euler rates."""
    (sr, cr), (sp, cp) = angles.roll, angles.pitch
    yaw = (sr * v[1] + cr * v[2]) / cp
    return v[0] + sp * yaw, cr * v[1] - sr * v[2], yaw


@kernel
def rate_bias(angles: Directions, rates: Vector) -> Vector:
    """Part of Ω̇ = W⁻¹Φ̈ + bias that is quadratic in Φ̇."""
    by_roll, by_pitch = euler_map_slopes(angles, rates)
    return combine(rates[0], by_roll, rates[1], by_pitch)


@kernel
def tip_in_body(arm: ArmParameters, angles: Array) -> Vector:
    """Position d of the tip; leaves joints and points in the arm."""
    arm_kinematics(arm, angles)
    tip, lanes = arm.points.shape[0] - 1, arm.lanes
    return get(arm.points, (tip, 0), lanes), get(arm.points, (tip, 1), lanes), get(arm.points, (tip, 2), lanes)


@kernel
def mass_factors(p: LagrangianParameters, tangent: Vector, tip: Vector) -> MassFactors:
    """Factors of the mass matrix of ν."""
    m, i = p.mass, p.inertia
    swing = 1.0 / (p.door_inertia + m * p.distance_from_hinge * p.distance_from_hinge)
    arm = cross(tangent, tip)
    lever = m * p.distance_from_hinge
    c = lever * lever * swing
    square = m * dot(tip, tip)
    xx = i[0, 0] + square - m * tip[0] * tip[0] - c * arm[0] * arm[0]
    yy = i[1, 1] + square - m * tip[1] * tip[1] - c * arm[1] * arm[1]
    zz = i[2, 2] + square - m * tip[2] * tip[2] - c * arm[2] * arm[2]
    xy = i[0, 1] - m * tip[0] * tip[1] - c * arm[0] * arm[1]
    xz = i[0, 2] - m * tip[0] * tip[2] - c * arm[0] * arm[2]
    yz = i[1, 2] - m * tip[1] * tip[2] - c * arm[1] * arm[2]
    a, b, d = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    r = 1.0 / (xx * a + xy * b + xz * d)
    inverse = (r * a, r * b, r * d, r * (xx * zz - xz * xz), r * (xy * xz - xx * yz), r * (xx * yy - xy * xy))
    return MassFactors(inverse, (lever * swing * arm[0], lever * swing * arm[1], lever * swing * arm[2]), swing)


@kernel
def solve_mass(factors: MassFactors, moment: Vector, torque: Number) -> tuple[Vector, Number]:
    """Ω̇ and α̈ for a moment on the vehicle (body axes) and a torque in the hinge."""
    (xx, xy, xz, yy, yz, zz), g = factors.inverse, factors.gain
    x, y, z = moment[0] - g[0] * torque, moment[1] - g[1] * torque, moment[2] - g[2] * torque
    turning = (xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z)
    return turning, factors.swing * torque - dot(g, turning)


@kernel
def force_on_tip(
    p: LagrangianParameters,
    angles: Directions,
    rates: Vector,
    door_rate: Number,
    thrust: Number,
    tip: Vector,
    turning: Vector,
    swinging: Number,
) -> Vector:
    """Force w of the door on the tip, body axes, for body rates Ω and accelerations Ω̇ and α̈."""
    reach = p.distance_from_hinge
    of_contact = combine(reach * swinging, angles.tangent, -reach * door_rate * door_rate, angles.leaf)
    of_tip = combine(1.0, cross(turning, tip), 1.0, cross(rates, cross(rates, tip)))
    acceleration = combine(1.0, of_contact, -1.0, of_tip)
    x, y, z = combine(p.mass, acceleration, p.mass * p.gravity, angles.vertical)
    return x, y, z - thrust


@kernel
def hinge_torque(p: LagrangianParameters, angle: Number, rate: Number) -> Number:
    """Torque of damping, friction, spring and disturbance, in the sense of damping."""
    torque = p.damping * rate + p.stiffness * (angle - p.rest_angle) + p.disturbance
    if p.friction > 0.0:
        torque = torque + p.friction * tanh(rate / p.friction_rate)
    return torque


@kernel
def body_accelerations(
    p: LagrangianParameters,
    angles: Directions,
    factors: MassFactors,
    tip: Vector,
    rates: Vector,
    door: tuple[Number, Number],
    inputs: tuple[Number, Number, Number, Number],
) -> tuple[Vector, Number]:
    """Accelerations Ω̇ and α̈ for body rates Ω, [α, α̇] and [f_t, T]."""
    none = 0.0 * tip[0]
    drift = force_on_tip(p, angles, rates, door[1], inputs[0], tip, (none, none, none), none)
    gyroscopic = cross(rates, transform(p.inertia, rates))
    x, y, z = combine(1.0, cross(tip, drift), -1.0, gyroscopic)
    moment = (x + inputs[1], y + inputs[2], z + inputs[3])
    torque = -p.distance_from_hinge * dot(angles.tangent, drift) - hinge_torque(p, door[0], door[1])
    return solve_mass(factors, moment, torque)


@kernel
def lagrangian_accelerations(
    p: LagrangianParameters,
    q: tuple[Number, Number, Number, Number],
    v: tuple[Number, Number, Number, Number],
    inputs: tuple[Number, Number, Number, Number],
    tip: Vector,
) -> tuple[Number, Number, Number, Number]:
    """Accelerations q̈ = [Φ̈, α̈] = [W(Ω̇ − bias), α̈] at q, q̇ = v, [f_t, T] and d."""
    angles = directions(q[0], q[1], q[3] - q[2])
    factors = mass_factors(p, angles.tangent, tip)
    euler_rates = (v[0], v[1], v[2])
    rates = euler_map(angles, euler_rates)
    turning, swinging = body_accelerations(p, angles, factors, tip, rates, (q[3], v[3]), inputs)
    x, y, z = euler_map_inverse(angles, combine(1.0, turning, -1.0, rate_bias(angles, euler_rates)))
    return x, y, z, swinging
