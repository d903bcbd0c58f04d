"""Kernels of `DisturbanceObserver` and `PositionController`, up to the wanted force; their docstrings have the equations."""

from __future__ import annotations

import math
from typing import NamedTuple

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.numba_types.records import Record, Vector3

_UNWINDING = 10.0
"""How much faster than the observer its inner state follows at the bound; not by more than all of it in one period."""
_AVERAGED = 4.0
"""Time over which δ̂ of free flight is averaged once it has settled [s]: a gust is over when the tip is on the leaf."""


class ObserverMemory(Record):
    """Numbers of a disturbance observer, and what it remembers."""

    inner: Vector3  # ν [N/s]
    outer: Vector3  # μ [N]
    estimate: Vector3  # δ̂, world frame [N]
    started: int  # whether it has begun
    gain: float  # c [kg/s²]
    rate: float  # 1/τ [rad/s]
    damping: float  # a_1
    limit: float  # largest δ̂ along an axis [N]


class ControllerNumbers(Record):
    """Numbers of a position controller."""

    mass: float  # m_A [kg]
    weight: float  # m g [N]
    most_lift: float  # largest change of the vertical δ̂ at the leaf [N]
    position_gain: Vector3
    velocity_gain: Vector3


class ControllerMemory(Record):
    """What a position controller remembers."""

    acting: Vector3  # force that acted [N]
    free: Vector3  # δ̂ of free flight [N]
    free_time: float  # for how long that was flown [s]


class ControllerInputs(Record):
    """What a position controller follows, world frame."""

    vehicle_position: Vector3  # P [m]
    vehicle_velocity: Vector3  # Ṗ [m/s]
    position: Vector3  # P of the setpoint [m]
    velocity: Vector3  # Ṗ of the setpoint [m/s]
    acceleration: Vector3  # P̈ of the setpoint [m/s²]
    planned: Vector3  # planned force of the tip on the door [N]
    normal: Vector3  # unit direction in which the observer is not heeded, or zero


class Found(Record):
    """What a position controller finds, world frame."""

    force: Vector3  # wanted F, without the limits [N]
    disturbance: Vector3  # δ̂ that it counts on [N]


class Control(NamedTuple):
    """One position controller."""

    observer: ObserverMemory
    numbers: ControllerNumbers
    memory: ControllerMemory
    inputs: ControllerInputs
    found: Found


@kernel
def observe_disturbance(observer: ObserverMemory, position: Array, force: Array, time_step: float) -> None:
    """One period of the observer."""
    gain, rate, damping, limit = observer.gain, observer.rate, observer.damping, observer.limit
    unwinding = _UNWINDING * rate / max(_UNWINDING * rate * time_step, 1.0)
    for k in range(3):
        estimate = observer.estimate[k]
        if observer.started == 0:
            observer.outer[k] = -gain * position[k]  # starts from δ̂ = 0, wherever the vehicle is
        observer.inner[k] -= time_step * rate**2 * (estimate + force[k])
        observer.outer[k] += time_step * (observer.inner[k] - damping * rate * estimate)
        raw = gain * position[k] + observer.outer[k]
        bounded = min(max(raw, -limit), limit)
        observer.estimate[k] = bounded
        observer.outer[k] += bounded - raw  # anti-windup: both states stay where the bound is reached, not beyond
        observer.inner[k] += unwinding * (bounded - raw)
    observer.started = 1


@kernel
def align_disturbance(
    observer: ObserverMemory, x: float, y: float, up: float, to_x: float, to_y: float, to_up: float, velocity: Array
) -> None:
    """Set δ̂ along one direction, at rest there."""
    if observer.started == 0:
        return
    estimate, inner, outer = observer.estimate, observer.inner, observer.outer
    change = x * (to_x - estimate[0]) + y * (to_y - estimate[1]) + up * (to_up - estimate[2])
    direction = (x, y, up)
    off = 0.0
    for k in range(3):
        estimate[k] += change * direction[k]
        outer[k] += change * direction[k]
        settled = observer.damping * observer.rate * estimate[k] - observer.gain * velocity[k]
        off += direction[k] * (settled - inner[k])
    for k in range(3):
        inner[k] += off * direction[k]


@kernel
def bound_windup(control: Control, share: float) -> None:
    """Keep δ̂ near what it was in free flight: upwards within `most_lift`, and along a leaf that the tip may slip on."""
    observer, free, most = control.observer, control.memory.free, control.numbers.most_lift
    normal, velocity = control.inputs.normal, control.inputs.vehicle_velocity
    x, y, up = free[0], free[1], free[2]
    if share > 0.0:
        align_disturbance(observer, -normal[1], normal[0], 0.0, x, y, up, velocity)
    lift = observer.estimate[2] - up
    if abs(lift) > most:
        align_disturbance(observer, 0.0, 0.0, 1.0, x, y, up + math.copysign(most, lift), velocity)


@kernel
def learn_free_flight(control: Control, touches: bool, time_step: float, share: float) -> None:
    """Follow δ̂ of free flight; at the leaf, where it is heeded, beside the vertical."""
    free, estimate = control.memory.free, control.observer.estimate
    if not touches:
        control.memory.free_time += time_step
        part = 1.0 if control.memory.free_time < _AVERAGED else min(time_step / _AVERAGED, 1.0)
        for k in range(3):
            free[k] += part * (estimate[k] - free[k])
    else:
        free[0] += (1.0 - share) * (estimate[0] - free[0])
        free[1] += (1.0 - share) * (estimate[1] - free[1])


@kernel
def wanted_force(control: Control, time_step: float, share: float, push: float) -> None:
    """One period of observer and controller. Of the force along the normal, a share is `push` in place of position control's."""
    numbers, inputs, found = control.numbers, control.inputs, control.found
    force, disturbance = found.force, found.disturbance
    estimate, free, most = control.observer.estimate, control.memory.free, numbers.most_lift
    normal, planned = inputs.normal, inputs.planned
    observe_disturbance(control.observer, inputs.vehicle_position, control.memory.acting, time_step)
    touches = planned[0] != 0.0 or planned[1] != 0.0 or planned[2] != 0.0
    if touches:
        bound_windup(control, share)
    learn_free_flight(control, touches, time_step, share)
    for k in range(3):
        disturbance[k] = share * free[k] + (1.0 - share) * estimate[k]
    disturbance[2] += share * min(max(estimate[2] - free[2], -most), most)
    along = normal[0] * disturbance[0] + normal[1] * disturbance[1] + normal[2] * disturbance[2]
    made = 0.0
    for k in range(3):
        disturbance[k] -= along * normal[k]
        correction = inputs.acceleration[k]
        correction += numbers.velocity_gain[k] * (inputs.velocity[k] - inputs.vehicle_velocity[k])
        correction += numbers.position_gain[k] * (inputs.position[k] - inputs.vehicle_position[k])
        force[k] = planned[k] - disturbance[k] + numbers.mass * correction
        made += normal[k] * force[k]
    for k in range(3):
        force[k] += share * (push - made) * normal[k]
    force[2] += numbers.weight
