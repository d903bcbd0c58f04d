r"""Kernel of an estimate: what the bank knew at the last pose, carried on to now, and where tip and leaf are then.

With the age a of the pose, :math:`P + a\dot P + \tfrac12 a^2\ddot P` and :math:`\alpha + a\dot\alpha`.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.control.kernels.tip import TipMotion, tip_on_leaf
from doorman.control.kernels.under_way_step import rates_of_euler
from doorman.estimation.leaf.kernels.acting_step import Ring, Tick, find_now
from doorman.estimation.leaf.kernels.report import LeafOutputs, LeafState
from doorman.kinematics.doors.leaf.leaf_kernels import (
    LeafNumbers,
    angle_of_face,
    contact_from_hinge,
    leaf_before,
    leaf_direction,
    leaf_normal,
)
from doorman.kinematics.vehicles.arms.arm import ArmParameters
from doorman.numba_types.records import Record, Vector3


class ContactNumbers(Record):
    """Where the tip is to touch the leaf."""

    up: Vector3  # u of the door
    distance: float  # D_V [m]
    height: float  # D_H [m]
    lever: float  # speed of the contact point along the normal for a unit rate of α [m]


class LeafNow(Record):
    """Where the leaf is, and how it moves."""

    angle: float  # α [rad]
    rate: float  # α̇ [rad/s]


class Carried(Record):
    """What is known now, beside the reduced state; as in `Estimate`."""

    position: Vector3
    velocity: Vector3
    attitude_rates: Vector3
    wind: Vector3
    tip_force: Vector3
    normal: Vector3
    along: Vector3
    contact_point: Vector3
    tip: Vector3
    friction: Annotated[Array, 2]
    rotation: Annotated[Array, 9]  # R(Φ), row by row
    tip_angle: float
    tip_speed: float
    normal_force: float
    touches: float  # probability that the tip touches,
    rests: float  # that the leaf at which it is rests,
    stopped: float  # and that it is on what does not move


class Carrying(NamedTuple):
    """One estimator's vehicle, leaf and results."""

    arm: ArmParameters
    leaf: LeafNumbers
    contact: ContactNumbers
    ring: Ring
    tick: Tick
    touching: Array  # 1 or 0 of each hypothesis, whether the tip touches, shape (M,)
    resting: Array
    stopping: Array
    found: Carried
    attitude: Array  # result: Φ, shape (3,) [rad]
    door: LeafNow  # result
    arm_angles: Array  # result: H, shape (n,)
    tip: TipMotion  # scratch
    turning: Array  # scratch: Ω of a vehicle that turns about the vertical alone, shape (3,) [rad/s]


@kernel
def carry_on(p: Carrying, state: LeafState, outputs: LeafOutputs, chances: Array, age: float) -> float:
    """Fill the results; returns the pitch's cosine."""
    found, door = p.found, p.door
    for k in range(3):
        moves, gains = state.velocity[k], outputs.gains[k]
        found.position[k] = state.position[k] + age * moves + 0.5 * age**2 * gains
        found.velocity[k] = moves + age * gains
        found.wind[k] = outputs.wind[k]
    find_now(p.ring, p.attitude, p.arm_angles)
    door.rate = state.joint_rate
    door.angle = state.joint + age * state.joint_rate
    flat = _turn(p)
    tip_angle, tip_rate = tip_on_leaf(
        p.arm, p.leaf, p.contact.lever, found.position, found.velocity, p.attitude, p.turning, p.arm_angles,
        p.tick.arm_rates, p.tip,
    )  # fmt: skip
    found.tip_angle = tip_angle - angle_of_face(p.leaf, state.face, p.contact.lever)
    found.tip_speed = -p.contact.lever * tip_rate
    found.normal_force = outputs.normal_force
    for k in range(2):
        found.friction[k] = state.friction[k]
    _place_leaf(p)
    found.touches = _chance(p.touching, chances)
    found.rests = _chance(p.resting, chances)
    found.stopped = _chance(p.stopping, chances)
    return flat


@kernel
def _turn(p: Carrying) -> float:
    """Attitude, its rates, and the rates with which the tip's speed counts: without what tilting gives it."""
    found, roll, pitch, yaw = p.found, p.attitude[0], p.attitude[1], p.attitude[2]
    turns = rates_of_euler(p.attitude, p.tick.body_rates)
    for k in range(3):
        found.attitude_rates[k] = turns[k]
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    rotation = (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )
    for k in range(3):
        for j in range(3):
            found.rotation[3 * k + j] = rotation[k][j]
        p.turning[k] = turns[2] * rotation[2][k]
    return cp


@kernel
def _place_leaf(p: Carrying) -> None:
    """Where the leaf is, and the tip and its force on it."""
    found, leaf, contact, angle = p.found, p.leaf, p.contact, p.door.angle
    force, along, up = found.normal_force, found.friction[0], found.friction[1]
    normal, direction, before = leaf_normal(leaf, angle), leaf_direction(leaf, angle), leaf_before(leaf, angle)
    for k in range(3):
        found.normal[k], found.along[k] = normal[k], direction[k]
        found.tip_force[k] = force * normal[k] + along * direction[k] + up * contact.up[k]
        found.tip[k] = found.position[k] + p.tip.position[k]
        found.contact_point[k] = leaf.hinge[k] + contact_from_hinge(
            contact.distance, before, contact.height, direction[k], normal[k], contact.up[k]
        )


@kernel
def _chance(are: Array, chances: Array) -> float:
    """Probability of some hypotheses."""
    total = 0.0
    for j in range(chances.shape[0]):
        total += are[j] * chances[j]
    return total
