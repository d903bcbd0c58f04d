"""Findings about a door's URDF: what it has beside a leaf on one hinge."""

from __future__ import annotations

import math

from doorman.feasibility.report import Finding, Severity, graded
from doorman.feasibility.task import joint_in_words
from doorman.model import Model


def door_findings(model: Model) -> list[Finding]:
    """What is taken for granted about the door."""
    names = model.door.standing_joints
    message = f"{len(names)} joints of the door beside '{model.door.section.hinge}' could move"
    if names:
        message += f", and stand at zero: {', '.join(names)}"
    return [
        _as_read(model),
        Finding(
            "door's joints", graded(not names, Severity.WARNING), message, float(len(names)), 0.0, "joints",
            f"type=\"fixed\" in the URDF for joints that stand still; the one that opens is door.hinge, "
            f"'{model.door.section.hinge}'" if names else "",
        )
    ]  # fmt: skip


def _as_read(model: Model) -> Finding:
    """How the URDF was understood, in words; `door.closed` corrects it."""
    door = model.door
    grows = "grows" if door.joint_value(door.angle_of_opening(0.1)) > door.closed else "falls"
    closed = f"{door.closed:.3f} m" if door.slides else f"{math.degrees(door.closed):.1f}°"
    message = (
        f"{joint_in_words(door)}; joint '{door.section.hinge}' is closed at {closed} and {grows} as the "
        f"door opens, into {math.degrees(door.azimuth) + 0.0:.0f}° from the world's x axis"
    )
    advice = ""
    if door.closed_is_guessed:
        message += "; that is a guess, as no jamb tells where it is closed"
        advice = f"door.closed = {door.closed:.4g} in the scenario, or the true value of '{door.section.hinge}'"
    return Finding("door as read", graded(not advice, Severity.WARNING), message, door.closed, -math.inf, "rad", advice)
