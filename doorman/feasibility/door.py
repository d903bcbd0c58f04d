"""Findings about a door's URDF: what it has beside a leaf on one hinge."""

from __future__ import annotations

from doorman.feasibility.report import Finding, Severity, graded
from doorman.model import Model


def door_findings(model: Model) -> list[Finding]:
    """What is taken for granted about the door.

    Args:
        model: Model of the scenario.

    Returns:
        The findings.
    """
    names = model.door.standing_joints
    message = f"{len(names)} joints of the door beside '{model.door.section.hinge}' could move"
    if names:
        message += f", and stand at zero: {', '.join(names)}"
    return [
        Finding(
            "door's joints", graded(not names, Severity.WARNING), message, float(len(names)), 0.0, "joints",
            f"type=\"fixed\" in the URDF for joints that are meant to stand; the one that opens is door.hinge, "
            f"'{model.door.section.hinge}'" if names else "",
        )
    ]  # fmt: skip
