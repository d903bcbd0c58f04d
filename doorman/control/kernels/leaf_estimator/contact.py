"""Whether the tip of `LeafEstimator` touches the leaf, and where the first touch finds the face."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.control.kernels.contact_step import TOUCHING, declare_contact, listen_to_noise, watch_contact
from doorman.control.kernels.door_filter.memory import ANGLE, INERTIA, RATE
from doorman.control.kernels.hinge_step import ESTIMATE
from doorman.control.kernels.hinge_step import RATE as HINGE_RATE
from doorman.control.kernels.hinge_step import TORQUE as HINGE_TORQUE
from doorman.control.kernels.leaf_estimator.forces import (
    FIRST_RESISTANCE,
    MOVING,
    friction_share,
    least_force,
    pull,
    weight_ahead,
)
from doorman.control.kernels.leaf_estimator.memory import (
    ANGLE_DEVIATION,
    CLOSED,
    DEEPEST,
    FACE,
    FACE_VARIANCE,
    GHOST,
    HAS_MOVED,
    HINGE_SCALE,
    LAST,
    LEVER,
    MEASURED,
    MET,
    MORE,
    OPENED,
    RESISTS,
    SHUT,
    SOUGHT,
    START,
    STOOD,
    TOUCHED_AT,
    LeafMemory,
)
from doorman.control.kernels.leaf_estimator.tip_sensor import feel_beside, is_read, learn_offset, presses, tell_wind
from doorman.control.kernels.vehicle_step import OUTER_FORCE
from doorman.control.kernels.wind_step import feel_wind, lose_contact, meet_contact, wind_doubt

Array = NDArray[np.float64]

_NEAR = 0.03
"""A tip that is farther from the leaf's place does not touch it [m]."""
FACE_DEVIATION, _MEASURED = 0.02, 0.3
"""Deviation of where the face stands [m], which the first touch measures in so long [s],"""
_STOPPED, _WENT_ON = 0.03, 0.015
"""with a tip that has stopped [m/s]; one that moves on by the second, or back, has met nothing [m]."""
_AJAR = 0.04
"""No face stands so far behind its place: a leaf that is met there has been opened [m]."""
_TIP_NOISE, _TIP_TIME = 0.003, 0.05
"""Noise of the tip's place, which is a new one after the latter [m], [s]."""
_DRAWN_BACK, _FAR_BACK, _FADED = 0.02, 0.06, 0.4
"""A tip that draws back by more than the first, while it feels less than the last, a share of what the hinge resists with, or of
what shuts a leaf whose closer is stronger than its friction, does not touch; nor does one that draws back by more than the second
[rad], unless it feels what no wind explains,"""
_CERTAIN = 3.0
"""which is more than so many deviations of the wind: a closer drives the leaf after the tip;"""
_GHOST, _GHOST_RATE, _GHOST_SUM = 1.5, 0.06, 0.3
"""nor one that moves on, faster than the second [rad/s], as if a room door opened by itself, or moves back as if the hinge drove
it harder than it resists, by more than the first [N m]: a sum of its momentum, up to the last [N m s],"""
_LIGHTEST = 0.6
"""with a leaf of this share of the expected inertia: a filter that follows a free tip makes its leaf ever lighter;"""
_BEHIND = 0.02
"""nor one that is farther before the closed leaf's place [m], by more than twice the deviation of that: the frame stops it."""
_SETTLED = 0.5
"""A touch that is younger may bounce [s]."""
_PAST = 0.007
"""A tip that is farther than it last was in contact has met the leaf again [rad]."""


@kernel
def begin_leaf(e: LeafMemory) -> None:
    """Forget what resists the leaf: something went wrong. It stands where the tip left it, or farther on."""
    memory, door, first = e.memory, e.door, e.first
    memory[SOUGHT], stands = 1.0, door.state[ANGLE]
    door.memory[:], door.state[:], door.covariance[:] = first.memory, first.state, first.covariance
    door.state[ANGLE] = stands
    for observer in (e.torque, e.quick, e.bare):
        observer[HINGE_TORQUE], observer[HINGE_RATE], observer[ESTIMATE] = 0.0, math.nan, 0.0
    memory[STOOD] = -math.inf
    memory[DEEPEST], memory[GHOST] = math.inf, 0.0
    driven = max(-weight_ahead(e), 0.0)  # its friction is more, as it stands
    memory[RESISTS], memory[HAS_MOVED], memory[MORE] = FIRST_RESISTANCE * e.numbers[HINGE_SCALE] + driven, 0.0, 0.0


@kernel
def find_contact(
    e: LeafMemory, tip_angle: float, tip_rate: float, normal: tuple[float, float, float], reading: float, now: float,
    time_step: float, seeks: bool,
) -> bool:  # fmt: skip
    """Whether the tip touches, and what that tells of the wind."""
    memory, lever, felt = e.memory, e.numbers[LEVER], e.vehicle[OUTER_FORCE : OUTER_FORCE + 3]
    read = is_read(e)
    reach = _NEAR + 2.0 * math.sqrt(memory[FACE_VARIANCE]) * memory[CLOSED]
    near = seeks and lever * (tip_angle - e.door.state[ANGLE]) < reach
    if not seeks:
        declare_contact(e.contact, False)
        memory[SOUGHT] = 0.0
    elif memory[SOUGHT] == 0.0:
        begin_leaf(e)
    was, force = e.contact[TOUCHING] != 0.0, presses(e, normal)
    follow_wind(e, normal, was, near, reading, time_step)
    touching = False
    if seeks:
        heeded = force if near or was or read else 0.0
        touching = watch_contact(e.contact_numbers, e.contact, heeded, time_step, math.inf)
    if touching and not was:
        memory[DEEPEST] = tip_angle
        note_touch(memory, now, tip_rate)
    if read:
        if touching:
            memory[DEEPEST], memory[LAST] = min(memory[DEEPEST], tip_angle), now
        return touching
    if near and not touching and tip_angle < memory[DEEPEST] - _PAST and math.isfinite(memory[DEEPEST]):
        touching = True
        note_touch(memory, now, tip_rate)
        declare_contact(e.contact, True)
        expected = max((memory[RESISTS] + memory[MORE] + weight_ahead(e)) / lever, least_force(e))
        meet_contact(e.wind, normal[0], normal[1], normal[2], expected - force)
        force = expected
    doubt = wind_doubt(e.wind.covariance, normal)
    if touching and is_no_contact(e, tip_angle, tip_rate, force, doubt, now, time_step):
        touching = False
        declare_contact(e.contact, False)
        lose_contact(e.wind, felt)
    if touching:
        memory[LAST] = now
    return touching


@kernel
def note_touch(memory: Array, now: float, tip_rate: float) -> None:
    """Take in when and how fast the tip touched; one that bounces still touches since then."""
    memory[OPENED], memory[GHOST] = -tip_rate, 0.0
    if now - memory[LAST] > _SETTLED:
        memory[TOUCHED_AT] = now


@kernel
def follow_wind(
    e: LeafMemory, normal: tuple[float, float, float], was: bool, near: bool, reading: float, time_step: float
) -> None:
    """Without contact the wind is what is felt; in contact, a sensor of the tip's force says how much of it is."""
    felt, read = e.vehicle[OUTER_FORCE : OUTER_FORCE + 3], is_read(e)
    pulled = pull(normal, e.wind.state, felt)
    if read and was:
        tell_wind(e, normal, time_step)
    elif read:
        feel_beside(e, normal, time_step)
    elif not was:
        feel_wind(e.wind, felt, near, time_step)
    if not (was or near):
        listen_to_noise(e.contact, pulled, time_step)
        if read:
            learn_offset(e, reading)


@kernel
def is_no_contact(
    e: LeafMemory,
    tip_angle: float,
    tip_rate: float,
    force: float,
    doubt: float,
    now: float,
    time_step: float,
) -> bool:
    """Whether what the tip does contradicts a contact."""
    memory, lever = e.memory, e.numbers[LEVER]
    memory[DEEPEST] = min(memory[DEEPEST], tip_angle)
    scale, gained = e.numbers[HINGE_SCALE], -tip_rate - memory[OPENED]
    memory[OPENED] = -tip_rate
    bears = max(memory[RESISTS] + max(memory[MORE], 0.0) + weight_ahead(e), 0.0)
    hinge, excess = lever * force * time_step - _LIGHTEST * e.first.state[INERTIA] * gained, 0.0
    settled = now - memory[TOUCHED_AT] > _SETTLED
    if tip_rate < -_GHOST_RATE:
        excess = -hinge
    elif settled and tip_rate > MOVING and force < _CERTAIN * doubt:
        excess = hinge - bears * time_step
    memory[GHOST] = max(0.0, memory[GHOST] + excess - _GHOST * scale * time_step)
    friction = friction_share(e) * (memory[RESISTS] + memory[MORE])
    shuts = bears - 2.0 * friction
    faded = lever * force < _FADED * (shuts if shuts > 0.0 else bears)
    drawn = tip_angle - memory[DEEPEST]
    gone = drawn > _DRAWN_BACK if faded else drawn > _FAR_BACK and force < _CERTAIN * doubt
    back = settled and tip_rate > MOVING and gone
    behind = lever * (tip_angle - e.numbers[SHUT]) > _BEHIND + 2.0 * math.sqrt(memory[FACE_VARIANCE])
    if not (back or behind or memory[GHOST] > _GHOST_SUM * scale):
        return False
    memory[GHOST] = 0.0
    if back or behind:
        e.door.state[ANGLE], e.door.state[RATE] = memory[DEEPEST], 0.0
    else:
        memory[DEEPEST] = math.inf  # the leaf is farther on, nobody knows where
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
    if abs(memory[MET] - before) > _WENT_ON and abs(speed) > _STOPPED:
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
