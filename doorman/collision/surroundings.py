"""What stands beside a task's door, and which of it the vehicle could touch."""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.collision.rows.listed import Surroundings
from doorman.exceptions import ScenarioError
from doorman.kinematics.contact import Contact
from doorman.kinematics.coupling import Coupling
from doorman.kinematics.doors.door import Door
from doorman.kinematics.doors.leaf.travel import Travel
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.scenario import Scenario

_REACHES_IN = 0.02
"""Depth from which on a disc counts as in a jamb, or a leaf's face behind the frame's: the check measures it exactly [m]."""
ROUNDED = 1e-6
"""By which numbers of a URDF or a rotation are rounded, and radius of a ball that stands for a point [m]."""
_RIGHT_ANGLE = math.radians(1.0)
"""A leaf that is open by no more beyond 90° leaves its vehicle between the jambs [rad]."""


def surroundings_of(door: Door, contact: Contact, travel: Travel, distance: float, radius: float) -> Surroundings:
    """A vehicle that pulls stays before the wall; one whose tip, D_V from the hinge, is near an edge begins beside a jamb."""
    if door.in_plane:
        return "face"
    if not door.framed:
        return "open"
    if not door.upright:
        return "wall" if door.panel is None else "panel"
    if door.side == "pull":
        return "wall" if door.frame_depth - door.contact_offset < _REACHES_IN else "corners"
    behind_the_tip = radius - ROUNDED <= distance <= door.width - radius + ROUNDED
    between = (behind_the_tip or contact.fits) and min(travel.start, travel.goal) > -_RIGHT_ANGLE
    return "doorway" if between or door.width < 2.0 * radius else "corners"


def stays_before(surroundings: Surroundings) -> bool:
    """Whether the vehicle stays before wall, panel or face all the way, or nothing stands around the leaf."""
    return surroundings in ("wall", "panel", "face", "open")


def reaches_the_lintel(
    scenario: Scenario, vehicle: Vehicle, door: Door, surroundings: Surroundings, height: float, tilt: float
) -> bool:
    """Whether the disc of a vehicle in the doorway, with its tip at D_H, could touch the lintel as it tilts so far."""
    given = scenario.door.frame_height
    if stays_before(surroundings):
        if given is not None:
            raise ScenarioError(
                "the vehicle stays out of the doorway, where no lintel counts", file=scenario.source,
                field="door.frame_height", given=given, allowed="none for this task",
            )  # fmt: skip
        return False
    arm, ends = vehicle.arm, np.abs([vehicle.lower_limits, vehicle.upper_limits]).max(axis=0)
    reach = np.linalg.norm([*arm.links, arm.point_offsets[-1]], axis=1).sum() + ends[arm.slides].sum()
    rim = vehicle.radius * math.sin(tilt)
    return door.frame_height is not None and bool(height + reach + rim > door.frame_height)


def hover_offset(coupling: Coupling, state: Array, far: float, surroundings: Surroundings) -> Array:
    """From the start to the hover: along the leaf's normal; where that leads into a jamb, straight out of the doorway."""
    door, radius = coupling.door, coupling.vehicle.radius
    touch = door.in_doorway(coupling.vehicle_position(state[:3], float(state[3]), state[5:]) - door.hinge_position)
    straight = far * door.away(float(state[3]))
    steps = touch + np.outer(np.linspace(0.0, 1.0, 20), door.in_doorway(straight))
    before = np.maximum(np.maximum(-door.frame_depth - steps[:, 0], steps[:, 0] - door.frame_back), 0.0)
    beside = np.maximum(np.minimum(steps[:, 1], door.width - steps[:, 1]), 0.0)
    free = door.side == "pull" or stays_before(surroundings)
    if free or np.hypot(before, beside).min() > radius - _REACHES_IN:
        return np.asarray(straight)
    outside = np.array([-door.frame_depth - radius - far, 0.5 * door.width, touch[2]])
    return np.asarray(door.from_doorway(outside - touch))


def check_contact(scenario: Scenario, door: Door, width: float, place: tuple[float, float]) -> None:
    """Refuse a tip that cannot touch at D_V and D_H of a leaf with this width [m]."""
    contact = scenario.contact
    if contact.kind != "push" and scenario.simulation.sensors.tip_force:
        raise ScenarioError(
            "only a tip without a gripper has a force sensor", file=scenario.source,
            field="simulation.sensors.tip_force", given=True, allowed='false, or contact.kind = "push"',
        )  # fmt: skip
    if door.slides:
        return  # in the middle of its face, or at a frame that it carries
    for field, given, limit, what in (
        ("contact.distance_from_hinge", place[0], width, "the leaf's width"),
        ("contact.height", place[1], door.height, "the leaf's height"),
    ):
        if not -ROUNDED <= given <= limit + ROUNDED:
            raise ScenarioError(
                "the contact point is off the leaf", file=scenario.source,
                field=field if contact.named is None else f"contact.{contact.named}", given=given,
                allowed=f"at most {limit:g} m, {what}",
            )  # fmt: skip
