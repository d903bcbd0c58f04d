"""The door of a scenario: which side of it the vehicle is on, and where it begins and ends."""

from __future__ import annotations

import math

from doorman.exceptions import ScenarioError
from doorman.kinematics.doors.door import Door, Side
from doorman.kinematics.doors.leaf.travel import Travel
from doorman.kinematics.doors.urdf.leaf_in_plane import LeafInPlane
from doorman.kinematics.doors.urdf.leaf_on_slide import read_leaf
from doorman.scenario import GoalSection, Scenario, StartSection

_BEYOND = math.radians(1.5)
"""A start or goal that is so far beyond the closed door, on the vehicle's side, means a door that is pulled [rad]."""
_DEFAULT_GOAL = math.pi / 9
"""α of a door that is pushed open by 70° [rad]."""
_DEFAULT_WAY = 0.3
"""Goal of a slide, from closed [m]."""
_ENDS = ("opening", "door_angle")
"""Keys of an end, of which one is given."""
_OF_HINGES = {
    "door": ("rest_angle",),
    "simulation": ("door_rest_angle", "door_width", "door_face_offset"),
}
"""Keys by section that mean nothing on a slide."""


def read_door(scenario: Scenario) -> Door:
    """Door of a scenario, as its URDF describes it."""
    contact, urdf = scenario.contact, scenario.door_urdf
    plain = Door(urdf, scenario.door)
    if plain.slides:
        _check_slide(scenario)
    outward = None
    if contact.named is not None:
        leaf = read_leaf(plain.urdf, plain.model, plain.section, contact, -1.0)
        if not isinstance(leaf, LeafInPlane):
            _, outward = leaf.contact(plain.closed, plain.into)
    if outward is None:
        return Door(urdf, scenario.door, contact.side or _likely_side(scenario, plain), contact)
    side: Side = "push" if float(outward @ plain.normal(0.5 * math.pi)) < 0.0 else "pull"
    if contact.side not in (None, side):
        raise ScenarioError(
            "the contact is on the other side of the leaf", file=scenario.source, field="contact.side",
            given=contact.side, allowed=f"{side}, or another contact.{contact.named}",
        )  # fmt: skip
    return Door(urdf, scenario.door, side, contact)


def read_travel(scenario: Scenario, door: Door) -> Travel:
    """Door angles at which a scenario begins and ends."""
    start = _end(scenario, door, "start", scenario.start)
    goal = _end(scenario, door, "goal", scenario.goal)
    if start is None:
        start = door.angle_of_opening(0.0)
    if goal is None and door.slides:
        goal = door.angle_of_opening(min(_DEFAULT_WAY, door.largest_opening))
    if goal is None:
        opening = min(0.5 * math.pi - _DEFAULT_GOAL, door.largest_opening)
        goal = max(_DEFAULT_GOAL, door.lower_limit) if door.side == "push" else door.angle_of_opening(opening)
    return Travel(start, goal)


def _end(scenario: Scenario, door: Door, name: str, end: StartSection | GoalSection) -> float | None:
    given = [key for key in _ENDS if getattr(end, key) is not None]
    if len(given) > 1:
        raise ScenarioError(
            f"{name} is given twice", file=scenario.source, field=f"{name}.{given[0]}", given=getattr(end, given[0]),
            allowed=f"one of {', '.join(f'{name}.{key}' for key in _ENDS)}",
        )  # fmt: skip
    return end.door_angle if end.opening is None else door.angle_of_opening(end.opening)


def _check_slide(scenario: Scenario) -> None:
    for name, end in (("start", scenario.start), ("goal", scenario.goal)):
        if end.door_angle is not None:
            raise ScenarioError(
                "a slide takes no angle", file=scenario.source, field=f"{name}.door_angle", given=end.door_angle,
                allowed=f"{name}.opening, in metres from closed",
            )  # fmt: skip
    for section, keys in _OF_HINGES.items():
        given = getattr(scenario, section)
        for key in keys:
            if getattr(given, key) != getattr(type(given)(), key):
                raise ScenarioError(
                    "a slide takes no such key", file=scenario.source, field=f"{section}.{key}", given=getattr(given, key),
                    allowed="none, as the door's joint is a slide",
                )  # fmt: skip


def _likely_side(scenario: Scenario, plain: Door) -> Side:
    """A drawer is before the vehicle; a tip that can only push opens one that goes away from it."""
    if plain.slides:
        travel = read_travel(scenario, plain)
        opens = plain.opening_of(travel.goal) > plain.opening_of(travel.start)
        return "push" if scenario.contact.kind == "push" and opens else "pull"
    ends = (scenario.start.door_angle, scenario.goal.door_angle)
    return "pull" if any(end is not None and end > 0.5 * math.pi + _BEYOND for end in ends) else "push"
