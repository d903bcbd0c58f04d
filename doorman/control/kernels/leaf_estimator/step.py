"""One period of `LeafEstimator`, on the memory of its parts."""

from __future__ import annotations

import math

from doorman.compilation import kernel
from doorman.control.kernels.attitude_step import rates_of_euler
from doorman.control.kernels.door_filter.memory import ANGLE, INERTIA, RATE
from doorman.control.kernels.door_filter.step import advance_door, pass_leaf, turn_wind
from doorman.control.kernels.hinge_step import RATE as HINGE_RATE
from doorman.control.kernels.leaf_estimator.contact import find_contact, first_touch
from doorman.control.kernels.leaf_estimator.forces import along, contact_force, friction_share
from doorman.control.kernels.leaf_estimator.memory import (
    AT,
    ATTITUDE_NOW,
    ATTITUDE_RATES,
    CLOSED,
    DOOR_ANGLE,
    DOOR_INERTIA,
    DOOR_RATE,
    FACE,
    FACE_OFFSET,
    FOUND,
    FRICTION_FORCE,
    FRICTION_SHARE,
    LEVER,
    MASS,
    MOVES,
    NORMAL_FORCE,
    NORMAL_PULL,
    NOT_FINITE,
    RESISTANCE,
    SINGULAR,
    SLID,
    TOUCHES,
    VEHICLE_RATE,
    WIND_NOW,
    YAW,
    LeafMemory,
)
from doorman.control.kernels.leaf_estimator.resistance import resists_with, watch_hinge
from doorman.control.kernels.leaf_estimator.tip_sensor import is_read, presses, take_reading
from doorman.control.kernels.tip import ATTITUDE, BODY_RATES, tip_on_leaf
from doorman.control.kernels.tip import VELOCITY as MEASURED_VELOCITY
from doorman.control.kernels.vehicle_step import FORCE, OUTER_FORCE, POSITION, VELOCITY, advance_vehicle
from doorman.control.kernels.wind_step import TURN, advance_wind
from doorman.kinematics.doors.leaf.leaf_kernels import angle_of_face, leaf_normal
from doorman.kinematics.rotations import SMALLEST_COSINE


@kernel
def advance_leaf(
    e: LeafMemory, seeks: bool, wanted: float, reading: float, pose_time: float, now: float, time_step: float
) -> int:
    """One period of the estimator."""
    numbers, memory, door, found = e.numbers, e.memory, e.door, e.found
    if abs(math.cos(e.seen[ATTITUDE + 1])) < SMALLEST_COSINE:
        return SINGULAR
    advance_vehicle(e.vehicle, e.acting, numbers[MASS], numbers[VEHICLE_RATE], pose_time, now, time_step)
    felt = e.vehicle[OUTER_FORCE : OUTER_FORCE + 3]
    for k in range(3):
        e.seen[MEASURED_VELOCITY + k] = e.vehicle[VELOCITY + k]
    advance_wind(e.wind, time_step)
    take_reading(e, reading, time_step)
    tip_angle, tip_rate = tip_on_leaf(e.arm, door.leaf, numbers[LEVER], e.seen, e.tip)
    if not abs(tip_angle + tip_rate) < math.inf:  # isfinite subtracts, and sums that are subtracted cancel
        return NOT_FINITE
    tip_angle -= angle_of_face(e.door.leaf, memory[FACE], e.numbers[LEVER])
    normal = leaf_normal(door.leaf, door.state[ANGLE])
    push = along(normal, e.acting[FORCE : FORCE + 3])
    touching = find_contact(e, tip_angle, tip_rate, normal, reading, now, time_step, seeks)
    if touching and memory[CLOSED] != 0.0:
        touching, tip_angle, tip_rate = first_touch(e, tip_angle, tip_rate, time_step)
    wind = e.wind.state
    acting = push + along(normal, wind)
    if time_step > 0.0:
        turn_wind(door.state, door.covariance, wind[TURN] * time_step)
        advance_door(
            door.numbers, door.leaf, door.memory, door.state, door.covariance, door.work, acting, touching, tip_angle,
            pose_time, now, time_step, wind[0], wind[1],
        )  # fmt: skip
    if touching:
        watch_hinge(e, normal, acting, push, time_step)
    else:
        e.torque[HINGE_RATE] = e.quick[HINGE_RATE] = e.bare[HINGE_RATE] = math.nan
        if seeks:
            pass_leaf(door.numbers, door.state, tip_angle)
    resistance = resists_with(e, touching, wanted, time_step)
    force = contact_force(e, normal, felt, acting, resistance, is_read(e), time_step) if touching else 0.0
    for k in range(3):
        found[AT + k], found[MOVES + k], found[WIND_NOW + k] = e.vehicle[POSITION + k], e.vehicle[VELOCITY + k], wind[k]
    tell_attitude(e, now - pose_time)
    found[FRICTION_FORCE], found[FRICTION_FORCE + 1] = memory[SLID], memory[SLID + 1]
    found[DOOR_ANGLE], found[DOOR_RATE], found[TOUCHES] = (
        door.state[ANGLE],
        door.state[RATE],
        (1.0 if touching else 0.0),
    )
    found[NORMAL_FORCE], found[RESISTANCE], found[FRICTION_SHARE] = force, resistance, friction_share(e)
    found[DOOR_INERTIA], found[FACE_OFFSET] = door.state[INERTIA], memory[FACE]
    found[NORMAL_PULL] = presses(e, normal)
    return FOUND


@kernel
def tell_attitude(e: LeafMemory, age: float) -> None:
    """Φ now, without jumps of ψ, and Φ̇."""
    attitude, found, memory = e.seen[ATTITUDE : ATTITUDE + 3], e.found, e.memory
    rates = rates_of_euler(attitude, e.seen[BODY_RATES : BODY_RATES + 3])
    for k in range(3):
        found[ATTITUDE_NOW + k], found[ATTITUDE_RATES + k] = attitude[k] + age * rates[k], rates[k]
    yaw = found[ATTITUDE_NOW + 2]
    memory[YAW] = yaw + 2.0 * math.pi * round((memory[YAW] - yaw) / (2.0 * math.pi))
    found[ATTITUDE_NOW + 2] = memory[YAW]
