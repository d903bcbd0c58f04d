"""Findings about a door's URDF: how it was read, and what it has beside a leaf on one hinge."""

from __future__ import annotations

import math

from doorman.feasibility.inputs.vehicle import standing_joints
from doorman.feasibility.report import Finding, Severity, found
from doorman.feasibility.task import joint_in_words
from doorman.model import Model


def door_findings(model: Model) -> list[Finding]:
    """What is taken for granted about the door."""
    hinge = f"'{model.door.section.hinge}'"
    more = f"; the one that opens is door.hinge, {hinge}"
    return [
        _as_read(model),
        standing_joints("door's joints", f"of the door beside {hinge}", model.door.standing_joints, more),
    ]


def _as_read(model: Model) -> Finding:
    """How the URDF was understood, in words; `door.closed` corrects it."""
    door, hinge = model.door, f"'{model.door.section.hinge}'"
    grows = "grows" if door.joint_value(door.angle_of_opening(0.1)) > door.closed else "falls"
    closed = f"{door.closed:.3f} m" if door.slides else f"{math.degrees(door.closed):.1f}°"
    guess = "; that is a guess, as no jamb tells where it is closed" if door.closed_is_guessed else ""
    return found(
        "door as read", not guess,
        f"{joint_in_words(door)}; joint {hinge} is closed at {closed} and {grows} as the door opens, into "
        f"{math.degrees(door.azimuth) + 0.0:.0f}° from the world's x axis{guess}",
        door.closed, -math.inf, "rad", f"door.closed = {door.closed:.4g} in the scenario, or the true value of {hinge}",
        Severity.WARNING,
    )  # fmt: skip
