"""What the hinge resists with: learnt while the door moves, and more while it sticks."""

from __future__ import annotations

import math

from doorman.compilation import kernel
from doorman.control.kernels.door_filter.memory import ANGLE, INERTIA, RATE, STIFFNESS
from doorman.control.kernels.hinge_step import BANDWIDTH, ESTIMATE, observe_hinge, restart_hinge
from doorman.control.kernels.leaf_estimator.forces import LEAST_RESISTANCE, MOVING
from doorman.control.kernels.leaf_estimator.memory import (
    GOAL,
    HAS_MOVED,
    HINGE_SCALE,
    LEVERS,
    MORE,
    MOST_RESISTANCE,
    RESISTS,
    STOOD,
    TIME_SCALE,
    TORQUE_SCALE,
    LeafMemory,
)
from doorman.control.kernels.wind_step import take_push

_LEARNT = 0.3
"""Time in which a door that moves teaches its resistance [s]."""
_NUDGE, _QUICKENS, _NUDGE_FADES = 0.6, 2.5, 0.5
"""Growth of the resistance that a plan is told of while a door sticks [N m/s], twice as quick at the second [N m], of the shipped
vehicle, and its end when the door moves [s]. Its bound is the torque of the largest push."""
_GIVES_WAY = 0.8
"""A seal or a latch gives way at once: a quick observer that finds so much less resistance of a room door is believed [N m]."""
_BREAKS_LOOSE = 0.05
"""A leaf that has gone no farther may still be held by a seal or a latch: it tells nothing of the wind [rad]."""
_HELD_FIRST = 0.1
"""Seals and latches hold the first degrees alone. Farther on, a leaf that stuck resists as it did in motion, not less [rad]."""
_NUDGED_WITHIN = 0.07
"""Nearer to the goal it grows in proportion [rad]."""
_STANDS_AT_GOAL = 0.015
"""Nearer than this it does not grow; as far beyond it falls, and a closer brings the leaf back [rad]."""


@kernel
def watch_hinge(
    e: LeafMemory, normal: tuple[float, float, float], acting: float, push: float, time_step: float
) -> None:
    """Let the hinge's observers take in what it is pushed with; a leaf that has come loose tells of the wind."""
    leaf, z, memory = e.door.leaf, e.door.state, e.memory
    angle, rate, inertia = z[ANGLE], z[RATE], z[INERTIA]
    observe_hinge(e.torque_numbers, leaf, e.torque, angle, rate, acting, inertia, time_step)
    observe_hinge(e.quick_numbers, leaf, e.quick, angle, rate, acting, inertia, time_step)
    bare = -observe_hinge(e.torque_numbers, leaf, e.bare, angle, rate, push, inertia, time_step)
    memory[STOOD] = max(memory[STOOD], angle)
    loose = memory[STOOD] - angle > _BREAKS_LOOSE
    if loose and e.torque_numbers[BANDWIDTH] > 0.0:  # an observer that is off tells nothing
        take_push(e.wind, normal, e.numbers[LEVERS], bare, -rate, z[STIFFNESS], time_step)


@kernel
def resists_with(e: LeafMemory, touching: bool, wanted: float, time_step: float) -> float:
    """Torque of the hinge against opening: learnt while the door moves, and more where it sticks [N m]."""
    memory, most = e.memory, e.numbers[MOST_RESISTANCE]
    opening, left = -e.door.state[RATE], e.door.state[ANGLE] - e.numbers[GOAL]
    if touching and opening > MOVING:
        learn_resistance(e, time_step)
    if touching and opening < min(0.3 * wanted, MOVING) and left > _STANDS_AT_GOAL:
        torque = e.numbers[TORQUE_SCALE]
        nudge, quickens = _NUDGE * torque / e.numbers[TIME_SCALE], _QUICKENS * torque
        memory[MORE] += nudge * (1.0 + memory[MORE] / quickens) * min(left / _NUDGED_WITHIN, 1.0) * time_step
        memory[MORE] = min(memory[MORE], max(most - memory[RESISTS], 0.0))
    elif touching and opening > -MOVING and left < -_STANDS_AT_GOAL:
        nudge = _NUDGE * e.numbers[TORQUE_SCALE] / e.numbers[TIME_SCALE]
        memory[MORE] -= nudge * min(-left / _NUDGED_WITHIN, 1.0) * time_step
        memory[MORE] = max(memory[MORE], LEAST_RESISTANCE * e.numbers[HINGE_SCALE] - memory[RESISTS])
    else:
        memory[MORE] *= math.exp(-time_step / _NUDGE_FADES)
    return float(min(max(memory[RESISTS] + memory[MORE], LEAST_RESISTANCE * e.numbers[HINGE_SCALE]), most))


@kernel
def learn_resistance(e: LeafMemory, time_step: float) -> None:
    """What a door that moves resists with. What it was pushed with beyond that, while it stuck, is part of it."""
    memory, least, learnt_before = e.memory, -e.quick[ESTIMATE] + _GIVES_WAY * e.numbers[HINGE_SCALE], 0.0
    if memory[STOOD] - e.door.state[ANGLE] >= _HELD_FIRST:
        learnt_before = memory[RESISTS]
        least = max(least, learnt_before)
    if e.torque_numbers[BANDWIDTH] > 0.0 and -e.torque[ESTIMATE] > least:
        restart_hinge(e.torque_numbers, e.torque, -least)
    before, share = memory[RESISTS], 1.0
    if memory[HAS_MOVED] != 0.0:
        share = min(time_step / _LEARNT, 1.0)
    learnt = before + share * (-e.torque[ESTIMATE] - before)
    memory[RESISTS], memory[HAS_MOVED] = min(learnt, max(least, LEAST_RESISTANCE * e.numbers[HINGE_SCALE])), 1.0
    memory[MORE] = max(min(memory[MORE], memory[MORE] + before - memory[RESISTS], least - learnt_before), 0.0)
