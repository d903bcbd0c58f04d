"""Kernels of `DisturbanceObserver` and `PositionController`, up to the wanted force; their docstrings have the equations."""

from __future__ import annotations

import math

from doorman.arrays import Array
from doorman.compilation import kernel

INNER, OUTER, ESTIMATE, STARTED, GAIN, RATE, DAMPING, LIMIT, OBSERVER = 0, 3, 6, 9, 10, 11, 12, 13, 14
"""Places in the observer's memory: two inner states and δ̂, whether it has begun, c, 1/τ, a_1 and the bound."""
MASS, LIFT, MOST_LIFT, POSITION_GAIN, VELOCITY_GAIN, NUMBERS = 0, 1, 2, 3, 6, 9
"""Places in the controller's numbers: m_A, m g, largest change of the vertical δ̂ at the leaf, and the gains of the axes."""
AT, MOVES, POSITION, VELOCITY, ACCELERATION, PLANNED, NORMAL, GIVEN = 0, 3, 6, 9, 12, 15, 18, 21
"""Places in what the controller is given, vectors of the world frame: P and Ṗ of the vehicle, those and P̈ of the setpoint, the
planned force of the tip on the door, and the unit direction in which the observer is not heeded, or zero."""
ACTING, FREE, FREE_TIME, MEMORY = 0, 3, 6, 7
"""Places in its memory: force that acted, δ̂ of free flight, and for how long that was flown."""

_UNWINDING = 10.0
"""How much faster than the observer its inner state follows at the bound; not by more than all of it in one period."""
_AVERAGED = 4.0
"""Time over which δ̂ of free flight is averaged once it has settled [s]: a gust is over when the tip is on the leaf."""


@kernel
def observe_disturbance(observer: Array, position: Array, force: Array, time_step: float) -> None:
    """One period of the observer."""
    gain, rate, damping, limit = observer[GAIN], observer[RATE], observer[DAMPING], observer[LIMIT]
    unwinding = _UNWINDING * rate / max(_UNWINDING * rate * time_step, 1.0)
    for k in range(3):
        estimate = observer[ESTIMATE + k]
        if observer[STARTED] == 0.0:
            observer[OUTER + k] = -gain * position[k]  # starts from δ̂ = 0, wherever the vehicle is
        observer[INNER + k] -= time_step * rate**2 * (estimate + force[k])
        observer[OUTER + k] += time_step * (observer[INNER + k] - damping * rate * estimate)
        raw = gain * position[k] + observer[OUTER + k]
        bounded = min(max(raw, -limit), limit)
        observer[ESTIMATE + k] = bounded
        observer[OUTER + k] += bounded - raw  # anti-windup: both states stay where the bound is reached, not beyond
        observer[INNER + k] += unwinding * (bounded - raw)
    observer[STARTED] = 1.0


@kernel
def align_disturbance(
    observer: Array, x: float, y: float, up: float, to_x: float, to_y: float, to_up: float, velocity: Array
) -> None:
    """Set δ̂ along one direction, at rest there."""
    if observer[STARTED] == 0.0:
        return
    e, n, o = ESTIMATE, INNER, OUTER
    change = x * (to_x - observer[e]) + y * (to_y - observer[e + 1]) + up * (to_up - observer[e + 2])
    direction = (x, y, up)
    off = 0.0
    for k in range(3):
        observer[e + k] += change * direction[k]
        observer[o + k] += change * direction[k]
        settled = observer[DAMPING] * observer[RATE] * observer[e + k] - observer[GAIN] * velocity[k]
        off += direction[k] * (settled - observer[n + k])
    for k in range(3):
        observer[n + k] += off * direction[k]


@kernel
def bound_windup(observer: Array, numbers: Array, memory: Array, velocity: Array, normal: Array, given: float) -> None:
    """Keep δ̂ near what it was in free flight: upwards within `MOST_LIFT`, and along a leaf that the tip may slip on."""
    x, y, up, most = memory[FREE], memory[FREE + 1], memory[FREE + 2], numbers[MOST_LIFT]
    if given > 0.0:
        align_disturbance(observer, -normal[1], normal[0], 0.0, x, y, up, velocity)
    lift = observer[ESTIMATE + 2] - up
    if abs(lift) > most:
        align_disturbance(observer, 0.0, 0.0, 1.0, x, y, up + math.copysign(most, lift), velocity)


@kernel
def wanted_force(
    observer: Array,
    numbers: Array,
    memory: Array,
    given: Array,
    time_step: float,
    share: float,
    push: float,
    out: Array,
) -> None:
    """One period of observer and controller. Of the force along the normal, a share is `push` in place of position control's."""
    normal, planned = given[NORMAL : NORMAL + 3], given[PLANNED : PLANNED + 3]
    observe_disturbance(observer, given[AT : AT + 3], memory[ACTING : ACTING + 3], time_step)
    touches = planned[0] != 0.0 or planned[1] != 0.0 or planned[2] != 0.0
    if touches:
        bound_windup(observer, numbers, memory, given[MOVES : MOVES + 3], normal, share)
    free, most = memory[FREE : FREE + 3], numbers[MOST_LIFT]
    if not touches:
        memory[FREE_TIME] += time_step
        part = 1.0 if memory[FREE_TIME] < _AVERAGED else min(time_step / _AVERAGED, 1.0)
        for k in range(3):
            free[k] += part * (observer[ESTIMATE + k] - free[k])
    else:
        free[0] += (1.0 - share) * (observer[ESTIMATE] - free[0])
        free[1] += (1.0 - share) * (observer[ESTIMATE + 1] - free[1])
    for k in range(3):
        out[3 + k] = share * free[k] + (1.0 - share) * observer[ESTIMATE + k]
    out[5] += share * min(max(observer[ESTIMATE + 2] - free[2], -most), most)
    along = normal[0] * out[3] + normal[1] * out[4] + normal[2] * out[5]
    made = 0.0
    for k in range(3):
        out[3 + k] -= along * normal[k]
        correction = given[ACCELERATION + k]
        correction += numbers[VELOCITY_GAIN + k] * (given[VELOCITY + k] - given[MOVES + k])
        correction += numbers[POSITION_GAIN + k] * (given[POSITION + k] - given[AT + k])
        out[k] = planned[k] - out[3 + k] + numbers[MASS] * correction
        made += normal[k] * out[k]
    for k in range(3):
        out[k] += share * (push - made) * normal[k]
    out[2] += numbers[LIFT]
