r"""Kernels of the coupled equations of motion of vehicle and door, with exact first derivatives (the paper's Lagrangian model).

With :math:`\nu = [\Omega,\ \dot\alpha]`, the leaf's direction c, its tangent s and the vertical k in body axes, the
acceleration of O_B and the force of the door on the tip are

.. math::
    a = D_V(\ddot\alpha\,s - \dot\alpha^2 c) + d\times\dot\Omega - \Omega\times(\Omega\times d),\quad
    w = m_A a - f_t e_3 + m_A g\,k

and the equations of motion, the Lagrange equations of q = [Φ, α] multiplied by :math:`[W^T, 1]`, are

.. math::
    I_A\dot\Omega + \Omega\times I_A\Omega = T + d\times w,\quad
    I_D\ddot\alpha = -D_V\,s^T w - (b\dot\alpha + \tau_c\tanh(\dot\alpha/\epsilon) + k(\alpha-\alpha_0) + \tau_d).

The arm is locked within them, as in the paper ("a sufficiently slow servomotor speed"): d enters, its rate does not.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.kinematics.arm import ArmParameters, arm_kinematics
from doorman.kinematics.vectors import Vector, combine, cross, dot, transform

Array = NDArray[np.float64]
Angles = tuple[float, float, float, float, float, float]


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
    arm: ArmParameters
    mass_matrix: Array
    """Scratch: mass matrix of ν, then its Cholesky factor, shape (4, 4)."""
    accelerations: Array
    """Scratch: ν̇, then q̈, shape (4, 1)."""
    partials: Array
    """Scratch: derivatives of ν̇ by [Φ, α, Ω, α̇, d, f_t, T], shape (4, 15)."""
    stage: Array
    """Scratch: state and its derivative at one stage, shape (2, 8 + n)."""
    stage_jacobian: Array
    """Scratch: Jacobian of q̈ at one stage, shape (4, 12 + n)."""
    sensitivity: Array
    """Scratch: sensitivities of the stage, of its derivative and their sum, shape (3, 8, 12 + 2n)."""


@kernel
def sines_and_cosines(x: Array) -> Angles:
    """Sine and cosine of roll, pitch and α − ψ, the only angles that the equations of motion know."""
    turn = x[3] - x[2]
    return np.sin(x[0]), np.cos(x[0]), np.sin(x[1]), np.cos(x[1]), np.sin(turn), np.cos(turn)


@kernel
def euler_map(angles: Angles, v: Vector) -> tuple[Vector, Vector, Vector]:
    """W⁻¹v, and its derivatives by roll and pitch; W⁻¹ maps Euler rates to body rates."""
    sr, cr, sp, cp, _, _ = angles
    value = (v[0] - sp * v[2], cr * v[1] + sr * cp * v[2], -sr * v[1] + cr * cp * v[2])
    by_roll = (0.0, value[2], -value[1])
    by_pitch = (-cp * v[2], -sr * sp * v[2], -cr * sp * v[2])
    return value, by_roll, by_pitch


@kernel
def euler_map_inverse(angles: Angles, v: Vector) -> Vector:
    """W v: body rates to Euler rates."""
    sr, cr, sp, cp, _, _ = angles
    yaw = (sr * v[1] + cr * v[2]) / cp
    return v[0] + sp * yaw, cr * v[1] - sr * v[2], yaw


@kernel
def directions_in_body(angles: Angles) -> tuple[Vector, Vector, Vector]:
    """Leaf's direction c = Rᵀ[cos α, sin α, 0], its tangent s = Rᵀ[−sin α, cos α, 0] and the vertical k = Rᵀe₃."""
    sr, cr, sp, cp, sd, cd = angles
    leaf = (cp * cd, cr * sd + sr * sp * cd, -sr * sd + cr * sp * cd)
    tangent = (-cp * sd, cr * cd - sr * sp * sd, -sr * cd - cr * sp * sd)
    return leaf, tangent, (-sp, sr * cp, cr * cp)


@kernel
def body_rates(angles: Angles, x: Array) -> Vector:
    """Ω = W⁻¹Φ̇."""
    return euler_map(angles, (x[4], x[5], x[6]))[0]


@kernel
def rate_bias(angles: Angles, x: Array) -> Vector:
    """Part of Ω̇ = W⁻¹Φ̈ + bias that is quadratic in Φ̇."""
    _, by_roll, by_pitch = euler_map(angles, (x[4], x[5], x[6]))
    return combine(x[4], by_roll, x[5], by_pitch)


@kernel
def tip_in_body(p: LagrangianParameters, x: Array) -> Vector:
    """Position d of the tip; leaves joints and points in `p.arm`."""
    arm_kinematics(p.arm, x[8:])
    tip = p.arm.points.shape[0] - 1
    return p.arm.points[tip, 0], p.arm.points[tip, 1], p.arm.points[tip, 2]


@kernel
def force_on_tip(p: LagrangianParameters, angles: Angles, x: Array, thrust: float, tip: Vector, nu: Array) -> Vector:
    """Force w of the door on the tip, body axes, for accelerations ν̇ in `nu` (4, 1)."""
    leaf, tangent, vertical = directions_in_body(angles)
    rates = body_rates(angles, x)
    reach = p.distance_from_hinge
    of_contact = combine(reach * nu[3, 0], tangent, -reach * x[7] * x[7], leaf)
    of_tip = combine(1.0, cross((nu[0, 0], nu[1, 0], nu[2, 0]), tip), 1.0, cross(rates, cross(rates, tip)))
    acceleration = combine(1.0, of_contact, -1.0, of_tip)
    weight = p.mass * p.gravity
    return combine(p.mass, acceleration, 1.0, combine(weight, vertical, -thrust, (0.0, 0.0, 1.0)))


@kernel
def fill_mass_matrix(p: LagrangianParameters, angles: Angles, tip: Vector) -> None:
    """Mass matrix of ν into `p.mass_matrix`: [[I_A + m(dᵀd − d dᵀ), m D_V s×d], [·, I_D + m D_V²]]."""
    tangent = directions_in_body(angles)[1]
    square = dot(tip, tip)
    coupling = cross(tangent, tip)
    for i in range(3):
        for j in range(3):
            p.mass_matrix[i, j] = p.inertia[i, j] - p.mass * tip[i] * tip[j]
        p.mass_matrix[i, i] += p.mass * square
        p.mass_matrix[i, 3] = p.mass * p.distance_from_hinge * coupling[i]
        p.mass_matrix[3, i] = p.mass_matrix[i, 3]
    p.mass_matrix[3, 3] = p.door_inertia + p.mass * p.distance_from_hinge * p.distance_from_hinge


@kernel
def factorize(matrix: Array) -> None:
    """Overwrite the lower triangle of a symmetric positive definite matrix by its Cholesky factor."""
    n = matrix.shape[0]
    for j in range(n):
        for k in range(j):
            for i in range(j, n):
                matrix[i, j] -= matrix[i, k] * matrix[j, k]
        scale = 1.0 / np.sqrt(matrix[j, j])
        for i in range(j, n):
            matrix[i, j] *= scale


@kernel
def substitute(factor: Array, columns: Array) -> None:
    """Overwrite `columns` (n, k) by the solutions of L Lᵀ y = column, L as `factorize` left it."""
    n, width = columns.shape
    for i in range(n):
        for k in range(i):
            for j in range(width):
                columns[i, j] -= factor[i, k] * columns[k, j]
        for j in range(width):
            columns[i, j] /= factor[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            for j in range(width):
                columns[i, j] -= factor[k, i] * columns[k, j]
        for j in range(width):
            columns[i, j] /= factor[i, i]


@kernel
def body_accelerations(p: LagrangianParameters, angles: Angles, x: Array, u: Array, tip: Vector) -> None:
    """Accelerations ν̇ = [Ω̇, α̈] into `p.accelerations`; leaves the factor of their mass matrix in `p.mass_matrix`."""
    rates = body_rates(angles, x)
    p.accelerations[:, :] = 0.0
    drift = force_on_tip(p, angles, x, u[0], tip, p.accelerations)
    gyroscopic = cross(rates, transform(p.inertia, rates))
    moment = cross(tip, drift)
    resistance = (
        p.damping * x[7]
        + p.friction * np.tanh(x[7] / p.friction_rate)
        + p.stiffness * (x[3] - p.rest_angle)
        + p.disturbance
    )
    for i in range(3):
        p.accelerations[i, 0] = u[1 + i] - gyroscopic[i] + moment[i]
    p.accelerations[3, 0] = -p.distance_from_hinge * dot(directions_in_body(angles)[1], drift) - resistance
    fill_mass_matrix(p, angles, tip)
    factorize(p.mass_matrix)
    substitute(p.mass_matrix, p.accelerations)


@kernel
def euler_accelerations(p: LagrangianParameters, angles: Angles, x: Array) -> None:
    """Turn ν̇ in `p.accelerations` into q̈ = [Φ̈, α̈] = [W(Ω̇ − bias), α̈]."""
    bias = rate_bias(angles, x)
    nu = p.accelerations
    value = euler_map_inverse(angles, (nu[0, 0] - bias[0], nu[1, 0] - bias[1], nu[2, 0] - bias[2]))
    for i in range(3):
        nu[i, 0] = value[i]


@kernel
def lagrangian_accelerations(p: LagrangianParameters, x: Array, u: Array) -> None:
    """Accelerations q̈ = [Φ̈, α̈] at `x` (8 + n,) under `u` (4 + n,) into `p.accelerations`."""
    angles = sines_and_cosines(x)
    body_accelerations(p, angles, x, u, tip_in_body(p, x))
    euler_accelerations(p, angles, x)
