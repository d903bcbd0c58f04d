"""What a tip at the leaf aims for: numbers of the whole-body problem that change from plan to plan."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from doorman.arrays import Array
from doorman.kinematics.numbers import Numbers
from doorman.model import Model
from doorman.planning.hinge import Hinge
from doorman.planning.pace import rate_to_goal
from doorman.planning.whole_body.contact import depth_of
from doorman.planning.whole_body.numbers import LEVEL_WEIGHT

_AT_GOAL = 0.014
"""Within about this the door is held, and not opened [rad]."""
_HOLD_LEAST, _HOLD_SLACK, _HOLD_OPENING = 0.3, 0.5, 0.4
"""For a held door: least force as a share of its resistance, the share of its friction by which the force is less than that,
and the weight of its speed."""
_COMES_BACK = 2.5
"""Share of its friction by which the force is less on a leaf that stands past the goal: a closer that is stronger brings it back,
where more than twice the friction is taken away."""
BRAKES = 2.0 / 3.0
"""Share of what resists that slows a leaf down before the goal. The last third keeps the tip on the leaf,
or makes up for an inertia or a resistance that is not as it is believed."""
_LEAST_SHARE = 0.2
"""Smallest push while braking, as a share of the force that carries the leaf."""
LEAST_RESISTANCE, _LEAST_FORCE = 0.05, 0.15
"""Least resistance of a hinge [N m], and least force of the tip at which a plan aims [N], for the shipped vehicle."""
_OPENING, _LEAST_OPENING = 20.0, 28.0
"""Weight of the rate of a held leaf that can gain 1 rad/s², of the shipped vehicle, and the least for a metre of lever: what is
nearer to its axis gains more by the same force."""
_LEAST_RATE = 1e-3
"""Least reference rate, as a share of the largest: the reference divides by it."""
_SHIPPED_RATE, _SHIPPED_FORCE = 0.32, 2.4
"""Opening rate of the shipped push [rad/s], and the force at the tip that gives its leaf that rate in a second [N]."""


class Leaf(NamedTuple):
    """What is known of the leaf as a plan begins."""

    angle: float
    """α [rad]."""
    rate: float
    """α̇ [rad/s]."""
    touched: bool
    """Whether the tip touches it."""
    hinge: Hinge
    """What a plan takes its hinge to do."""
    resistance: float
    """Torque of the hinge against the way to the goal now, beside the leaf's weight, not negative [N m]."""
    outer: Array = np.zeros(3)
    """Force on the vehicle beside its weight and the leaf's normal force: of wind, less what a tied tip bears in the face,
    shape (3,), world frame [N]."""


def references(model: Model, numbers: Numbers, leaf: Leaf, opening_rate: float) -> dict[str, Any]:
    """References and weights of a tip at the leaf, and the hinge that a plan counts on, by name.

    The leaf is steered by the force of a tip that can only press: it is bounded by what the hinge stops. A tied tip steers it by
    its rate alone, to the goal from either side.
    """
    hinge = leaf.hinge
    slows = hinge.friction * numbers.one("plan.time_step") / hinge.inertia
    sticks = {**hinge.numbers(), "door.sticks": float(slows > numbers.one("door.friction_rate"))}
    return sticks | (_held if model.contact.tied else _pressed)(model, numbers, leaf, opening_rate)


def _pressed(model: Model, numbers: Numbers, leaf: Leaf, opening_rate: float) -> dict[str, Any]:
    """References of a tip that touches the leaf, opens the door, and holds it at the goal.

    Errors of rate and force are weighed by what is large for the vehicle, or for a leaf that is large for it.
    """
    scale, lever, ahead = model.scale, model.coupling.lever_length, numbers.one("reference.sense")
    inertia, resistance, touch = leaf.hinge.inertia, leaf.resistance, float(leaf.touched)
    rubs = leaf.hinge.friction / max(resistance, leaf.hinge.friction, 1e-9)
    left = ahead * (numbers.one("reference.joint") - leaf.angle)
    holds = 1.0 / (1.0 + math.exp(min((left - _AT_GOAL) / (0.4 * _AT_GOAL), 50.0)))
    weight_torque = model.travel.ahead(model.door.weight_torque(leaf.angle))
    steady, lifts = resistance / lever, weight_torque / lever
    carried = max(steady + lifts, 0.0)
    least, depth = numbers.one("reference.least_force"), numbers.one("reference.depth")
    fastest, slowing = numbers.one("reference.opening_speed"), numbers.one("reference.deceleration")
    resists = max(resistance + weight_torque, LEAST_RESISTANCE * scale.torque)
    slowing, settling = min(BRAKES * resists / inertia, slowing), numbers.one("reference.settling")
    braking = inertia * _deceleration(opening_rate, ahead * leaf.rate, left, slowing, settling, scale.time) / lever
    past = min(max(-left / _AT_GOAL - 1.0, 0.0), 1.0)
    slack = _HOLD_SLACK + past * (_COMES_BACK - _HOLD_SLACK)
    force = max(steady * (1.0 - holds * slack * rubs) + lifts - braking, _LEAST_SHARE * carried)
    least = min(least, 0.5 * force)
    least_force = (1.0 - holds) * least + holds * min(least, _HOLD_LEAST * carried)
    depth *= 1.0 - holds
    if leaf.touched:
        depth = min(depth, depth_of(max(force, least_force, _LEAST_FORCE * scale.force), numbers))
    moves = numbers.one("door.inertia") * fastest / (lever * scale.time)
    rate = min(scale.rate, max(fastest / _SHIPPED_RATE, 1.0))
    large = max(scale.force, min(moves / _SHIPPED_FORCE, 1.0))
    level = LEVEL_WEIGHT if model.door.in_plane and leaf.touched else numbers.one("weights.level")
    return {
        "reference.thrust": _borne(model, leaf, force * touch), "reference.depth": depth,
        "reference.opening_speed": opening_rate, "reference.deceleration": slowing,
        "reference.force": force, "reference.least_force": least_force,
        "weights.level": level, "weights.approach": (1000.0 - 400.0 * touch) / scale.speed**2,
        "weights.opening": 100.0 * (1.0 - touch * holds * (1.0 - _HOLD_OPENING)) / rate**2,
        "weights.force": 0.2 * touch / large**2, "weights.least_force": 2.0 * touch / scale.force**2,
    }  # fmt: skip


def _held(model: Model, numbers: Numbers, leaf: Leaf, opening_rate: float) -> dict[str, Any]:
    """References of a tip that is tied to the leaf: the thrust holds the leaf, and what the tip bears beside the normal.

    A rate counts by what the force that speeds the leaf up changes in a second; a light leaf follows the noise of its rate else.
    """
    door, lever, scale = model.door, model.coupling.lever_length, model.scale
    rests = leaf.hinge.torque_at_rest(leaf.angle, door.rest_angle) + door.weight_torque(leaf.angle)
    least = _LEAST_OPENING * lever / scale.length
    opening = max(_OPENING * scale.rate**2 / numbers.one("reference.deceleration"), least)
    return {
        "reference.thrust": _borne(model, leaf, -rests / lever),
        "reference.opening_speed": max(opening_rate, _LEAST_RATE * numbers.one("reference.opening_speed")),
        "weights.opening": opening / scale.rate**2,
    }  # fmt: skip


def _borne(model: Model, leaf: Leaf, force: float) -> float:
    """Thrust of a vehicle that presses on the leaf with a force and stays where it is [N]."""
    rotors = force * model.door.normal(leaf.angle) - leaf.outer + [0.0, 0.0, model.vehicle.weight]
    return float(np.linalg.norm(rotors))


def _deceleration(speed: float, door_rate: float, left: float, slowing: float, settling: float, time: float) -> float:
    r"""Deceleration of a leaf that slows down as the reference :math:`v(s)` does, and returns to it where it is faster or slower.

    .. math:: a = \min(\dot s, v)\,v'(s) + (\dot s - v)/T
    """
    left = max(left, 0.0)
    wanted, beyond = (float(rate_to_goal(s, speed, slowing, settling)) for s in (left, left + _STEP))
    return max(max(min(door_rate, wanted), 0.0) * (beyond - wanted) / _STEP + (door_rate - wanted) / time, 0.0)


_STEP = 1e-6
"""Step of the difference that gives the slope of v [rad]."""
