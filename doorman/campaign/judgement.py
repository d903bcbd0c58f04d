"""Judgement: when a run counts as a success. This is the only place that decides it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

ANGLE_TOLERANCE = 2.0
"""Largest |final angle − target| [deg]."""
COMPLETED, GIVEN_UP = "completed", "given up"
"""Outcomes of a mission that went all its way, and of one that retreated to the hover instead."""


@dataclass(frozen=True)
class Judgement:
    """Whether a run succeeded, and why not."""

    success: bool
    reason: str
    """Empty for a success."""
    safe: bool
    """Whether nothing was touched and the mission came to its end, in a hover or holding the door, be it that it was given up."""


def judge(summary: Mapping[str, Any]) -> Judgement:
    """Judge a flight by its summary.

    A success touched nothing, completed its mission, and left the door within 2° of the target at the flight's end.

    Args:
        summary: As `doorman.simulate` gives it.

    Returns:
        The judgement; the reasons are the mission's own where it gave up.
    """
    error = final_error(summary)
    reasons = []
    outcome = summary["outcome"]
    if summary["collisions"]:
        reasons.append(f"{summary['collisions']} contacts other than tip and leaf")
    if outcome != COMPLETED:
        said = summary["reason"]
        reasons.append(f"{outcome}: {said}" if said else str(outcome))
    if not abs(error) < ANGLE_TOLERANCE:
        reasons.append(f"the door ended {error:+.1f}° from the target")
    safe = not summary["collisions"] and outcome in (COMPLETED, GIVEN_UP)
    return Judgement(not reasons, "; ".join(reasons), safe)


def final_error(summary: Mapping[str, Any]) -> float:
    """Door's final angle minus target [deg]; NaN if the summary has none."""
    final = summary["final_door_angle_deg"]
    return math.nan if final is None else float(final) - float(summary["target_door_angle_deg"])
