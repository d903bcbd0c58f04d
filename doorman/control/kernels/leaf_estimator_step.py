"""Kernels of `LeafEstimator`: one period of it, on the memory of its parts."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.control.kernels.attitude_step import rates_of_euler
from doorman.control.kernels.contact_step import TOUCHING, declare_contact, listen_to_noise, watch_contact
from doorman.control.kernels.door_step import (
    ANGLE,
    FRICTION,
    INERTIA,
    RATE,
    STIFFNESS,
    DoorMemory,
    advance_door,
    pass_leaf,
)
from doorman.control.kernels.hinge_step import BANDWIDTH, ESTIMATE, observe_hinge, restart_hinge
from doorman.control.kernels.hinge_step import RATE as HINGE_RATE
from doorman.control.kernels.hinge_step import TORQUE as HINGE_TORQUE
from doorman.control.kernels.leaf import SLIDES, leaf_direction, leaf_normal, leaf_weight
from doorman.control.kernels.tip import ATTITUDE, BODY_RATES, tip_on_leaf
from doorman.control.kernels.tip import VELOCITY as MEASURED_VELOCITY
from doorman.control.kernels.vehicle_step import FORCE, OUTER_FORCE, POSITION, VELOCITY, advance_vehicle
from doorman.control.kernels.wind_step import (
    WindMemory,
    advance_wind,
    feel_wind,
    lose_contact,
    meet_contact,
    take_push,
    take_unexplained,
    wind_doubt,
)
from doorman.kinematics.rotations import SMALLEST_COSINE
from doorman.kinematics.vehicles.arm import ArmParameters

Array = NDArray[np.float64]

(
    MASS, LEVER, VEHICLE_RATE, GOAL, REST, START, MOST_RESISTANCE, ANGLE_DEVIATION, LEVERS, CLOSER, AHEAD, UP,
    FORCE_SCALE, TORQUE_SCALE, TIME_SCALE, HINGE_SCALE, NUMBERS,
) = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 14, 15, 16, 17, 18  # fmt: skip
"""Places in the numbers: m_A, D_V, ω of the vehicle's observer, α of goal, spring at rest and start, torque of the largest push,
deviation of the tip's way at the start, levers of the wind on vehicle and leaf together, the closer's torque, sense of α towards
the goal, the door's axis,
and the scales of the vehicle's forces, torques and times, and of the hinge's torques."""
(
    TOUCHED_AT, STOOD, SOUGHT, DEEPEST, GHOST, RESISTS, HAS_MOVED, MORE, FACE, FACE_VARIANCE, CLOSED, MET, MEASURED, YAW,
    SLID, MEMORY,
) = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 16  # fmt: skip
"""Places in the memory: time of the touch, α where the leaf stood, whether it was sought, α that the tip came to, for how long
the leaf seems to open by itself, what the hinge resists with, whether that was seen in motion, and more while it sticks; where
the face stands, with its variance, whether the leaf is closed, where it was met, NaN before, and for how long it was measured;
heading without jumps; and the force of the tip on the face."""
(
    AT, MOVES, ATTITUDE_NOW, ATTITUDE_RATES, WIND_NOW, FRICTION_FORCE, DOOR_ANGLE, DOOR_RATE, TOUCHES, NORMAL_FORCE, RESISTANCE,
    FRICTION_SHARE, DOOR_INERTIA, FACE_OFFSET, NORMAL_PULL, FOUND_SIZE,
) = 0, 3, 6, 9, 12, 15, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26  # fmt: skip
"""Places in what is found: `LeafEstimate`'s fields."""
FOUND, SINGULAR, NOT_FINITE = range(3)
"""How a period ended: Euler angles are singular, or the tip is nowhere."""

_NEAR = 0.03
"""A tip that is farther from the leaf's place does not touch it [m]."""
FACE_DEVIATION, _MEASURED = 0.02, 0.3
"""Deviation of where the face stands [m], which the first touch measures in so long [s],"""
_STOPPED, _WENT_ON = 0.03, 0.015
"""with a tip that has stopped [m/s]; one that goes on by the second has met nothing [m]."""
_AJAR = 0.04
"""No face stands so far behind its place: a leaf that is met there has been opened [m]."""
_TIP_NOISE, _TIP_TIME = 0.003, 0.05
"""Noise of the tip's place, which is a new one after the latter [m], [s]."""
_LEAST = 0.2
"""Force of the shipped vehicle's tip that touches [N]."""
_CARRIED = 0.5
"""Share of the normal force that friction is believed to carry."""
_MOVES = 0.02
"""A door that is faster teaches its resistance [rad/s],"""
_LEARNT = 0.3
"""in this time [s]."""
_NUDGE, _QUICKENS, _NUDGE_FADES = 0.6, 2.5, 0.5
"""Growth of the resistance that a plan is told of while a door sticks [N m/s], twice as quick at the second [N m], of the shipped
vehicle, and its end when the door moves [s]. Its bound is the torque of the largest push."""
_GIVES_WAY = 0.8
"""A seal or a latch gives way at once: a quick observer that finds so much less resistance of a room door is believed [N m]."""
_BREAKS_LOOSE = 0.05
"""A leaf that has gone no farther may still be held by a seal or a latch: it tells nothing of the wind [rad]."""
_NUDGED_WITHIN = 0.07
"""Nearer to the goal it grows in proportion [rad]."""
_STANDS_AT_GOAL = 0.015
"""Nearer than this it does not grow [rad]."""
_DRAWN_BACK, _FAR_BACK, _FADED = 0.02, 0.06, 0.4
"""A tip that draws back by more than the first, while it feels less than the last, a share of what the hinge resists with, or of
what shuts a leaf whose closer is stronger than its friction, does not touch; nor does one that draws back by more than the second
[rad], unless it feels what no wind explains,"""
_CERTAIN = 3.0
"""which is more than so many deviations of the wind: a closer drives the leaf after the tip;"""
_GHOST, _GHOST_RATE, _GHOST_TIME = 2.0, 0.06, 0.4
"""nor one that moves on, faster than this [rad/s] and for longer [s], as if a room door opened by itself with
more [N m],"""
_SETTLED = 0.5
"""once the touch is older [s]."""
_PAST = 0.007
"""A tip that is farther than it last was in contact has met the leaf again [rad]."""
LEAST_RESISTANCE, FIRST_RESISTANCE = 0.05, 0.3
"""Of a room door's hinge, and what is believed at first [N m]."""


class LeafMemory(NamedTuple):
    """All that one estimator's kernels read and write."""

    numbers: Array
    """Shape (NUMBERS,)."""
    memory: Array
    """Shape (MEMORY,)."""
    seen: Array
    """What the sensors say: P, Ṗ, Φ, Ω, H and Ḣ, shape (12 + 2n,)."""
    acting: Array
    """Place in `vehicle_step`'s given of what acts on the vehicle and of its centre of mass, shape (GIVEN,)."""
    vehicle: Array
    """Memory of the vehicle's observer."""
    door: DoorMemory
    first: DoorMemory
    """The same before anything is known of the leaf."""
    wind: WindMemory
    torque_numbers: Array
    """Of the observer of the hinge's torque,"""
    torque: Array
    """and its memory."""
    quick_numbers: Array
    """Of one that is quick,"""
    quick: Array
    """and its memory."""
    bare: Array
    """Memory of one that knows no wind, with the numbers of the first."""
    contact_numbers: Array
    """Of the contact monitor."""
    contact: Array
    """Its memory."""
    arm: ArmParameters
    tip: Array
    """Scratch, shape (6,)."""
    found: Array
    """Result, shape (FOUND_SIZE,)."""


@kernel
def advance_leaf(e: LeafMemory, seeks: bool, wanted: float, pose_time: float, now: float, time_step: float) -> int:
    """One period of the estimator.

    Args:
        e: Its memory; `e.seen` and `e.acting` are filled.
        seeks: Whether the tip is to touch the leaf.
        wanted: Opening rate that is asked for [rad/s].
        pose_time: When position, velocity and attitude were true [s].
        now: [s].
        time_step: Since the last call [s].

    Returns:
        FOUND, or what is wrong.
    """
    numbers, memory, door, found = e.numbers, e.memory, e.door, e.found
    if abs(math.cos(e.seen[ATTITUDE + 1])) < SMALLEST_COSINE:
        return SINGULAR
    advance_vehicle(e.vehicle, e.acting, numbers[MASS], numbers[VEHICLE_RATE], pose_time, now, time_step)
    felt = e.vehicle[OUTER_FORCE : OUTER_FORCE + 3]
    for k in range(3):
        e.seen[MEASURED_VELOCITY + k] = e.vehicle[VELOCITY + k]
    advance_wind(e.wind, time_step)
    tip_angle, tip_rate = tip_on_leaf(e.arm, door.leaf, numbers[LEVER], e.seen, e.tip)
    if not abs(tip_angle + tip_rate) < math.inf:  # isfinite subtracts, and sums that are subtracted cancel
        return NOT_FINITE
    tip_angle -= angle_of_face(e)
    normal = leaf_normal(door.leaf, door.state[ANGLE])
    push = along(normal, e.acting[FORCE : FORCE + 3])
    touching = find_contact(e, tip_angle, tip_rate, normal, push, now, time_step, seeks)
    if touching and memory[CLOSED] != 0.0:
        touching, tip_angle, tip_rate = first_touch(e, tip_angle, tip_rate, time_step)
    wind = e.wind.state
    acting = push + along(normal, wind)
    if time_step > 0.0:
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
    force = contact_force(e, normal, felt, acting, resistance, time_step) if touching else 0.0
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
    found[NORMAL_PULL] = pull(normal, wind, felt)
    return FOUND


@kernel
def along(direction: tuple[float, float, float], vector: Array) -> float:
    """A vector's share along a direction."""
    return float(direction[0] * vector[0] + direction[1] * vector[1] + direction[2] * vector[2])


@kernel
def pull(direction: tuple[float, float, float], wind: Array, felt: Array) -> float:
    """Wind less outer force along a direction [N]."""
    x, y, up = wind[0] - felt[0], wind[1] - felt[1], wind[2] - felt[2]
    return float(direction[0] * x + direction[1] * y + direction[2] * up)


@kernel
def angle_of_face(e: LeafMemory) -> float:
    """By how much α of the tip is less as the face stands before its place; see `LeafMotion.angle_of_face` [rad]."""
    share = e.memory[FACE] / e.numbers[LEVER]
    return float(share if e.door.leaf[SLIDES] != 0.0 else math.asin(share))


@kernel
def least_force(e: LeafMemory) -> float:
    """Of a tip that touches [N]."""
    return float(_LEAST * e.numbers[FORCE_SCALE])


@kernel
def weight_ahead(e: LeafMemory) -> float:
    """Torque of the leaf's weight against opening [N m]."""
    return float(e.numbers[AHEAD] * leaf_weight(e.door.leaf, e.door.state[ANGLE]))


@kernel
def friction_share(e: LeafMemory) -> float:
    """Share of friction in what the hinge resists with, beside the leaf's weight."""
    z = e.door.state
    closer = max(z[STIFFNESS] * (e.numbers[REST] - z[ANGLE]), 0.0) + abs(e.numbers[CLOSER])
    slides = z[FRICTION] + LEAST_RESISTANCE * e.numbers[HINGE_SCALE]
    return float(slides / (slides + closer))


@kernel
def begin_leaf(e: LeafMemory) -> None:
    """Forget where the leaf is, and what resists it: it may be anywhere since the last attempt."""
    memory, door, first = e.memory, e.door, e.first
    memory[SOUGHT] = 1.0
    door.memory[:], door.state[:], door.covariance[:] = first.memory, first.state, first.covariance
    for observer in (e.torque, e.quick, e.bare):
        observer[HINGE_TORQUE], observer[HINGE_RATE], observer[ESTIMATE] = 0.0, math.nan, 0.0
    memory[STOOD] = -math.inf
    memory[DEEPEST], memory[GHOST] = math.inf, 0.0
    driven = max(-weight_ahead(e), 0.0)  # its friction is more, as it stands
    memory[RESISTS], memory[HAS_MOVED], memory[MORE] = FIRST_RESISTANCE * e.numbers[HINGE_SCALE] + driven, 0.0, 0.0


@kernel
def find_contact(
    e: LeafMemory, tip_angle: float, tip_rate: float, normal: tuple[float, float, float], push: float, now: float,
    time_step: float, seeks: bool,
) -> bool:  # fmt: skip
    """Whether the tip touches; the wind is what is felt where it does not."""
    memory, lever, felt = e.memory, e.numbers[LEVER], e.vehicle[OUTER_FORCE : OUTER_FORCE + 3]
    reach = _NEAR + 2.0 * math.sqrt(memory[FACE_VARIANCE]) * memory[CLOSED]
    near = seeks and lever * (tip_angle - e.door.state[ANGLE]) < reach
    if not seeks:
        declare_contact(e.contact, False)
        memory[SOUGHT] = 0.0
    elif memory[SOUGHT] == 0.0:
        begin_leaf(e)
    was = e.contact[TOUCHING] != 0.0
    force = pull(normal, e.wind.state, felt)
    if not was:
        feel_wind(e.wind, felt, near, time_step)
        if not near:
            listen_to_noise(e.contact, force, time_step)
    touching = False
    if seeks:
        heeded = force if near or was else 0.0
        touching = watch_contact(e.contact_numbers, e.contact, heeded, time_step, math.inf)
    if touching and not was:
        memory[DEEPEST], memory[TOUCHED_AT] = tip_angle, now
    if near and not touching and tip_angle < memory[DEEPEST] - _PAST and math.isfinite(memory[DEEPEST]):
        touching, memory[TOUCHED_AT] = True, now
        declare_contact(e.contact, True)
        expected = max((memory[RESISTS] + memory[MORE] + weight_ahead(e)) / lever, least_force(e))
        meet_contact(e.wind, normal[0], normal[1], normal[2], expected - force)
        force = expected
    moves, doubt = push + along(normal, felt), wind_doubt(e.wind.covariance, normal)
    if touching and is_no_contact(e, tip_angle, tip_rate, moves, force, doubt, now, time_step):
        touching = False
        declare_contact(e.contact, False)
        lose_contact(e.wind, felt)
    return touching


@kernel
def is_no_contact(
    e: LeafMemory,
    tip_angle: float,
    tip_rate: float,
    moves: float,
    force: float,
    doubt: float,
    now: float,
    time_step: float,
) -> bool:
    """Whether what the tip does contradicts a contact."""
    memory, lever = e.memory, e.numbers[LEVER]
    memory[DEEPEST] = min(memory[DEEPEST], tip_angle)
    gains = moves / e.numbers[MASS] / lever
    opens_itself = (
        tip_rate < -_GHOST_RATE and lever * force - e.door.state[INERTIA] * gains < -_GHOST * e.numbers[HINGE_SCALE]
    )
    memory[GHOST] = memory[GHOST] + time_step if opens_itself else max(0.0, memory[GHOST] - time_step)
    bears = max(memory[RESISTS] + memory[MORE] + weight_ahead(e), 0.0)
    friction = friction_share(e) * (memory[RESISTS] + memory[MORE])
    shuts = bears - 2.0 * friction
    faded = lever * force < _FADED * (shuts if shuts > 0.0 else bears)
    drawn = tip_angle - memory[DEEPEST]
    gone = drawn > _DRAWN_BACK if faded else drawn > _FAR_BACK and force < _CERTAIN * doubt
    back = tip_rate > _MOVES and gone
    if now - memory[TOUCHED_AT] <= _SETTLED or not (back or memory[GHOST] > _GHOST_TIME):
        return False
    memory[GHOST] = 0.0
    if back:
        e.door.state[ANGLE], e.door.state[RATE] = memory[DEEPEST], 0.0
    return True


@kernel
def first_touch(e: LeafMemory, tip_angle: float, tip_rate: float, time_step: float) -> tuple[bool, float, float]:
    """Where the face stands, as a closed leaf stands at a known angle; whether anything has been met, and the tip on it."""
    memory, lever, start, z = e.memory, e.numbers[LEVER], e.numbers[START], e.door.state
    off, speed = lever * (tip_angle - start), -lever * tip_rate
    before = off + memory[FACE]
    if math.isnan(memory[MET]):
        memory[MET] = before
    if memory[MET] < -_AJAR:
        memory[CLOSED], memory[DEEPEST] = 0.0, tip_angle
        z[ANGLE], z[RATE] = tip_angle, 0.0
        return True, tip_angle, tip_rate
    if memory[MET] - before > _WENT_ON and speed > _STOPPED:
        memory[FACE], memory[FACE_VARIANCE], memory[MET], memory[DEEPEST] = 0.0, FACE_DEVIATION**2, math.nan, math.inf
        declare_contact(e.contact, False)
        lose_contact(e.wind, e.vehicle[OUTER_FORCE : OUTER_FORCE + 3])
        return False, tip_angle, tip_rate
    if abs(speed) < _STOPPED:
        noise = _TIP_NOISE**2 * max(_TIP_TIME / max(time_step, 1e-6), 1.0) + e.numbers[ANGLE_DEVIATION] ** 2
        gain = memory[FACE_VARIANCE] / (memory[FACE_VARIANCE] + noise)
        memory[FACE] += gain * off
        memory[FACE_VARIANCE] *= 1.0 - gain
        memory[MEASURED] += time_step
    memory[CLOSED] = 1.0 if memory[MEASURED] < _MEASURED else 0.0
    memory[DEEPEST] = start
    z[ANGLE], z[RATE] = start, 0.0
    return True, start, 0.0


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
    if touching and opening > _MOVES:
        learn_resistance(e, time_step)
    if touching and opening < min(0.3 * wanted, _MOVES) and left > _STANDS_AT_GOAL:
        torque = e.numbers[TORQUE_SCALE]
        nudge, quickens = _NUDGE * torque / e.numbers[TIME_SCALE], _QUICKENS * torque
        memory[MORE] += nudge * (1.0 + memory[MORE] / quickens) * min(left / _NUDGED_WITHIN, 1.0) * time_step
        memory[MORE] = min(memory[MORE], max(most - memory[RESISTS], 0.0))
    else:
        memory[MORE] *= math.exp(-time_step / _NUDGE_FADES)
    return float(min(max(memory[RESISTS] + memory[MORE], LEAST_RESISTANCE * e.numbers[HINGE_SCALE]), most))


@kernel
def learn_resistance(e: LeafMemory, time_step: float) -> None:
    """What a door that moves resists with. What it was pushed with beyond that, while it stuck, is part of it."""
    memory, least = e.memory, -e.quick[ESTIMATE] + _GIVES_WAY * e.numbers[HINGE_SCALE]
    if e.torque_numbers[BANDWIDTH] > 0.0 and -e.torque[ESTIMATE] > least:
        restart_hinge(e.torque_numbers, e.torque, -least)
    before, share = memory[RESISTS], 1.0
    if memory[HAS_MOVED] != 0.0:
        share = min(time_step / _LEARNT, 1.0)
    learnt = before + share * (-e.torque[ESTIMATE] - before)
    memory[RESISTS], memory[HAS_MOVED] = min(learnt, max(least, LEAST_RESISTANCE * e.numbers[HINGE_SCALE])), 1.0
    memory[MORE] = max(min(memory[MORE], memory[MORE] + before - memory[RESISTS], least), 0.0)


@kernel
def contact_force(
    e: LeafMemory, normal: tuple[float, float, float], felt: Array, acting: float, resistance: float, time_step: float
) -> float:
    """λ of vehicle and leaf that move as one; the wind takes what no contact explains."""
    memory, z, lever, wind = e.memory, e.door.state, e.numbers[LEVER], e.wind.state
    leaf, vehicle = z[INERTIA], e.numbers[MASS] * lever
    reaction = resistance if -z[RATE] > _MOVES else max(-e.torque[ESTIMATE], 0.0)
    reaction += weight_ahead(e)
    force = max((leaf * acting + vehicle * reaction) / (leaf + vehicle * lever), least_force(e))
    aside = leaf_direction(e.door.leaf, z[ANGLE])
    up = (e.numbers[UP], e.numbers[UP + 1], e.numbers[UP + 2])
    pressed, along_leaf, upwards = pull(normal, wind, felt), pull(aside, wind, felt), pull(up, wind, felt)
    carried = _CARRIED * max(pressed, force)
    share = min(1.0, carried / max(math.hypot(along_leaf, upwards), 1e-9))
    memory[SLID], memory[SLID + 1] = share * along_leaf, share * upwards
    take_unexplained(e.wind, aside[0], aside[1], aside[2], along_leaf - memory[SLID], time_step)
    take_unexplained(e.wind, up[0], up[1], up[2], upwards - memory[SLID + 1], time_step)
    take_unexplained(e.wind, normal[0], normal[1], normal[2], min(pressed - least_force(e), 0.0), time_step)
    return float(force)


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
