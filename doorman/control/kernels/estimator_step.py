"""Kernels of `Estimator`: one period of it, on the memory of its parts."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.control.kernels.attitude_step import LAG, learn_lag, rates_of_euler
from doorman.control.kernels.contact_step import TOUCHING, listen_to_noise, watch_contact
from doorman.control.kernels.door_filter.memory import ANGLE, INERTIA, RATE
from doorman.control.kernels.door_filter.step import advance_door, hinge_of, pass_leaf
from doorman.control.kernels.estimator_memory import (
    AT,
    BEYOND,
    DISTURBANCE,
    DOOR_INERTIA,
    DOUBTED,
    DREW_BACK,
    FREE,
    FREE_TIME,
    GRIPPED,
    GRIPS,
    IS_TOLD,
    LEAVING,
    LEVER,
    MASS,
    MEAN_WIND,
    MOVES,
    NEAR,
    NORMAL_FORCE,
    PUSH,
    PUSHING,
    RESPONSE_LAG,
    SMOOTHED,
    STATE,
    TIP_ANGLE,
    TIP_FORCE,
    TIP_SPEED,
    TOLD,
    TOUCHES,
    VEHICLE_RATE,
    WIND,
    WIND_NOW,
    WIND_RATE,
    YAW,
    EstimatorMemory,
)
from doorman.control.kernels.grip_step import along_normal, push_of_a_grip, rate_of_a_grip
from doorman.control.kernels.hinge_step import ESTIMATE, observe_hinge
from doorman.control.kernels.hinge_step import RATE as HINGE_RATE
from doorman.control.kernels.tip import ARM, ATTITUDE, BODY_RATES, tip_on_leaf
from doorman.control.kernels.tip import POSITION as MEASURED
from doorman.control.kernels.tip import VELOCITY as MEASURED_VELOCITY
from doorman.control.kernels.vehicle_step import (
    FORCE,
    OUTER_FORCE,
    POSITION,
    SEEN,
    VELOCITY,
    advance_vehicle,
)
from doorman.kinematics.doors.leaf.leaf_kernels import leaf_normal
from doorman.kinematics.rotations import SMALLEST_COSINE

Array = NDArray[np.float64]

FOUND, SINGULAR, NOT_FINITE = range(3)
"""How a period ended: Euler angles are singular, or the tip is nowhere."""

_REACH = 0.03
"""A tip that is farther from the leaf, beyond twice the deviation of where the leaf is, does not touch it [m]."""
_DRAWS_BACK = 0.04
"""A tip that moves away from the leaf faster than this [m/s]"""
_DOUBT = 0.4
"""is not believed to move the leaf with it for so long: the estimated force takes about as long to show that it has left [s]."""
_SMOOTHED = 0.05
"""Time over which the distance of tip and leaf is smoothed [s]."""
_AVERAGED = 30.0
"""Longest time in free flight over which the wind is averaged [s]."""


@kernel
def advance_estimate(
    e: EstimatorMemory, tie: int, pose_time: float, arm_age: float, now: float, time_step: float
) -> int:
    """One period of the estimator."""
    numbers, memory, found, door = e.numbers, e.memory, e.found, e.door
    age, lever = now - pose_time, numbers[LEVER]
    carry_on(e, age, arm_age)
    state = found[STATE:]
    for k in range(3):
        state[k] = e.carried[ATTITUDE + k]
    if abs(math.cos(state[1])) < SMALLEST_COSINE:
        return SINGULAR
    if memory[IS_TOLD] != 0.0:
        body_rates = e.seen[BODY_RATES : BODY_RATES + 3]
        learn_lag(e.response, memory[TOLD : TOLD + 3], state[:3], body_rates, time_step)
    advance_vehicle(e.vehicle, e.acting, numbers[MASS], numbers[VEHICLE_RATE], pose_time, now, time_step)
    for k in range(3):
        e.seen[MEASURED_VELOCITY + k] = e.carried[MEASURED_VELOCITY + k] = e.vehicle[VELOCITY + k]
        e.carried[MEASURED + k] = e.seen[MEASURED + k] + age * e.vehicle[VELOCITY + k]
    tip_angle, tip_rate = tip_on_leaf(e.arm, door.leaf, lever, e.seen, e.tip)
    if not abs(tip_angle + tip_rate) < math.inf:  # isfinite subtracts, and sums that are subtracted cancel
        return NOT_FINITE
    turned_rate = tip_rate
    if tie == GRIPPED:
        tip_rate = rate_of_a_grip(e, tip_angle, pose_time, now, time_step)
    else:
        e.grip[SEEN] = math.nan
    deviation = math.sqrt(max(door.covariance[ANGLE, ANGLE], 0.0))
    near = lever * (tip_angle - door.state[ANGLE] - 2.0 * deviation) < _REACH
    may_touch = near or e.contact[TOUCHING] != 0.0 or tie == LEAVING
    follow_wind(e, tie == FREE or not (may_touch or tie == GRIPPED), time_step)
    wind = memory[WIND : WIND + 3]
    normal = leaf_normal(door.leaf, door.state[ANGLE])
    normal_force = push = 0.0
    for k in range(3):
        found[TIP_FORCE + k] = wind[k] - e.vehicle[OUTER_FORCE + k]
        normal_force += normal[k] * found[TIP_FORCE + k]
        push += normal[k] * (e.acting[FORCE + k] + wind[k])
    if tie != GRIPPED and not may_touch:
        listen_to_noise(e.contact, normal_force, time_step)
    felt, distance = (normal_force if may_touch else 0.0), math.inf
    if numbers[GRIPS] == 0.0:
        distance = distance_to_leaf(e, tip_angle, tip_rate, time_step)
    touching = tie == GRIPPED
    if tie != GRIPPED and tie != FREE:
        touching = watch_contact(e.contact_numbers, e.contact, felt, time_step, distance)
    if tie == GRIPPED:
        push = push_of_a_grip(e, tip_angle, turned_rate, time_step)
    update_door(e, tie, touching, tip_angle, tip_rate, push, pose_time, now, time_step)
    state[3], state[4] = door.state[ANGLE], door.state[RATE]
    if tie == GRIPPED:
        state[3], state[4] = tip_on_leaf(e.arm, door.leaf, lever, e.carried, e.tip)[0], tip_rate
    n = e.arm.axes.shape[0]
    for k in range(n):
        state[5 + k] = e.carried[ARM + k]
    memory[YAW] = state[2] + 2.0 * math.pi * round((memory[YAW] - state[2]) / (2.0 * math.pi))  # without jumps at ±π
    state[2] = memory[YAW]
    hinge_of(door.numbers, door.leaf, door.state, door.covariance, door.hinge)
    for k in range(3):
        found[AT + k], found[MOVES + k], found[WIND_NOW + k] = e.vehicle[POSITION + k], e.vehicle[VELOCITY + k], wind[k]
    found[TIP_ANGLE], found[TIP_SPEED], found[NORMAL_FORCE] = tip_angle, -lever * tip_rate, normal_force
    found[NEAR], found[TOUCHES] = (1.0 if near else 0.0), (1.0 if touching else 0.0)
    found[DISTURBANCE], found[RESPONSE_LAG], found[PUSH] = e.hinge[ESTIMATE], e.response[LAG], push
    return FOUND


@kernel
def carry_on(e: EstimatorMemory, age: float, arm_age: float) -> None:
    """Attitude and joint angles of now, from what the sensors say; see `present`."""
    n = e.arm.axes.shape[0]
    for k in range(e.seen.shape[0]):
        e.carried[k] = e.seen[k]
    if age > 0.0:
        rates = rates_of_euler(e.seen[ATTITUDE : ATTITUDE + 3], e.seen[BODY_RATES : BODY_RATES + 3])
        for k in range(3):
            e.carried[ATTITUDE + k] += age * rates[k]
    if arm_age > 0.0:
        for k in range(n):
            e.carried[ARM + k] += arm_age * e.seen[ARM + n + k]


@kernel
def follow_wind(e: EstimatorMemory, free: bool, time_step: float) -> None:
    """In free flight the wind is what is felt; at the leaf a gust is forgotten, and what has blown on average stays."""
    memory, share = e.memory, 0.0
    if free and time_step > 0.0:
        memory[FREE_TIME] += time_step
        share = time_step / min(memory[FREE_TIME], _AVERAGED)
    part = min(e.numbers[WIND_RATE] * time_step, 1.0)
    for k in range(3):
        felt = e.vehicle[OUTER_FORCE + k]
        memory[MEAN_WIND + k] += share * (felt - memory[MEAN_WIND + k])
        memory[WIND + k] += part * ((felt if free else memory[MEAN_WIND + k]) - memory[WIND + k])


@kernel
def distance_to_leaf(e: EstimatorMemory, tip_angle: float, tip_rate: float, time_step: float) -> float:
    """Of the tip from where the leaf is believed to be, smoothed, and carried on by the lag of that [m]."""
    distance = e.numbers[LEVER] * (tip_angle - e.door.state[ANGLE])
    opening = e.numbers[LEVER] * (tip_rate - e.door.state[RATE])
    e.memory[SMOOTHED] += min(time_step / _SMOOTHED, 1.0) * (distance - e.memory[SMOOTHED])
    return float(e.memory[SMOOTHED] + _SMOOTHED * opening)


@kernel
def update_door(
    e: EstimatorMemory, tie: int, touching: bool, tip_angle: float, tip_rate: float, push: float, seen: float, now: float,
    time_step: float,
) -> None:  # fmt: skip
    """Let the door's filter and its hinge's observer take in where the tip is, where it is believed to touch."""
    door, memory = e.door, e.memory
    if tie == GRIPPED:
        follow_door(e, push, True, tip_angle, seen, now, time_step)
        inertia = door.state[INERTIA]
        observe_hinge(e.hinge_numbers, door.leaf, e.hinge, tip_angle, tip_rate, push, inertia, time_step)
        return
    memory[BEYOND] = math.nan
    doubted = doubts(e, touching, -e.numbers[LEVER] * tip_rate, now)
    touching = touching and not doubted
    follow_door(e, push, touching, tip_angle, seen, now, time_step)
    if touching:
        angle, rate, normal = door.state[ANGLE], door.state[RATE], leaf_normal(door.leaf, door.state[ANGLE])
        push, inertia = along_normal(e, normal), e.numbers[DOOR_INERTIA]
        observe_hinge(e.hinge_numbers, door.leaf, e.hinge, angle, rate, push, inertia, time_step)
        return
    e.hinge[HINGE_RATE] = math.nan
    if tie == PUSHING or tie == LEAVING:
        pass_leaf(door.numbers, door.state, tip_angle)


@kernel
def follow_door(
    e: EstimatorMemory, push: float, touching: bool, tip_angle: float, seen: float, now: float, time_step: float
) -> None:
    """One period of the door's filter."""
    if time_step > 0.0:
        d, x, y = e.door, e.memory[MEAN_WIND], e.memory[MEAN_WIND + 1]
        advance_door(
            d.numbers,
            d.leaf,
            d.memory,
            d.state,
            d.covariance,
            d.work,
            push,
            touching,
            tip_angle,
            seen,
            now,
            time_step,
            x,
            y,
        )


@kernel
def doubts(e: EstimatorMemory, touching: bool, tip_speed: float, now: float) -> bool:
    """Whether the tip has probably left the leaf, though its estimated force does not show that yet."""
    memory, draws_back = e.memory, touching and tip_speed < -_DRAWS_BACK
    if draws_back and memory[DREW_BACK] == 0.0 and now >= memory[DOUBTED]:
        memory[DOUBTED] = now + _DOUBT
    memory[DREW_BACK] = 1.0 if draws_back else 0.0
    return bool(now < memory[DOUBTED])
