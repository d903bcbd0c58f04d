"""The way out of the doorway, from the leaf to a hover before the door."""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.control.doorway import Doorway
from doorman.model import Model

ROOM = 0.05
"""Between disc and jambs, or a leaf, on the way out [m]."""
_BACK = 0.25
"""Way straight back from the leaf before the way out [m]."""
_LEAST_SLANT = 0.2
"""Least slant of a leaf against the way straight out, where going out frees the tip from the leaf."""


def in_the_doorway(model: Model, position: Array) -> bool:
    """Whether some of the rotor disc is between the jambs, where a leaf that shuts reaches it."""
    before = model.door.in_doorway(position - model.door.hinge_position)[0]
    return bool(
        model.door.upright and model.door.side == "push" and before > -model.door.frame_depth - model.vehicle.radius
    )


def way_out(model: Model, position: Array, door_angle: float) -> list[Array]:
    """Way from the leaf to a hover outside: straight out between the jambs, and back from the leaf first before the doorway.

    A vehicle that pulls goes back along the leaf's normal to where the leaf, however it swings, does not reach it. One that has
    moved a slide or a hatch goes back along the normal of its face.
    """
    if not model.door.upright:
        return [position + model.scenario.mission.hover_distance * model.door.away(door_angle)]
    if model.door.side == "pull":
        return _out_of_swing(model, position, door_angle)
    door, doorway = model.door, Doorway(model, margin=ROOM)
    outside = -model.vehicle.radius - model.scenario.mission.hover_distance

    def placed(components: Array) -> Array:
        return door.hinge_position + door.from_doorway(components)

    into, _, up = door.in_doorway(position - door.hinge_position)
    if in_the_doorway(model, position):
        # away from the hinge, where a leaf that shuts comes from
        beside = 0.5 * (doorway.middle + max(doorway.highest, doorway.middle))
        out, beyond = placed(np.array([outside, beside, up])), doorway.beyond(position)
        normal = door.normal(door_angle)
        if normal @ door.into < 0.0:  # straight out leads into a leaf that is open beyond 90°
            return [placed(np.array([into, beside, up])), out]
        if beyond == 0.0:
            return [out]
        aside = -beyond * door.along
        freed = max(float(aside @ normal), 0.0) / max(float(door.into @ normal), _LEAST_SLANT)
        return [position + aside - freed * door.into, out]
    back = position - _BACK * door.normal(door_angle)
    into, along, _ = door.in_doorway(back - door.hinge_position)
    return [back, placed(np.array([min(into, outside), along, up]))]


def _out_of_swing(model: Model, position: Array, door_angle: float) -> list[Array]:
    """Way back from a leaf that may come after the vehicle: along its normal, out of the leaf's circle, before the wall."""
    door, radius = model.door, model.vehicle.radius
    back = position - _BACK * door.normal(door_angle)
    into, along, up = door.in_doorway(position - door.hinge_position)
    away = door.in_doorway(-door.normal(door_angle))[:2]
    reach, at = door.width + radius + ROOM, np.array([into, along])
    forward = float(at @ away)
    room = forward**2 + reach**2 - float(at @ at)
    far = max(math.sqrt(max(room, 0.0)) - forward, model.scenario.mission.hover_distance)
    into, along = at + far * away
    out = np.array([min(into, -door.frame_depth - radius - ROOM), along, up])
    return [back, door.hinge_position + door.from_doorway(out)]
