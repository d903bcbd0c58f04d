"""Judgement: when a run counts as a success, and whether one that failed stated the true reason. Only this place decides it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from doorman.simulation.reality.causes import DRAUGHT, LATCHED, LATE, NEVER_CLOSED, NOISY, SEALED, SLIPPED, WIND
from doorman.summary import COMPLETED, GIVEN_UP, GOAL_MISSED, TOUCHED
from doorman.summary.outcome import KEPT_CONTACT, OPEN_TOLERANCE

TOLERANCE = {"deg": math.degrees(OPEN_TOLERANCE), "m": 0.014}
"""Largest |final angle − target|, or of a slide its opening, by unit: 2° are 1.4 cm at a lever of 0.4 m."""
_LARGEST_PUSH = 15.0
"""With which a success pushes the leaf [N]."""
_ENDS = (COMPLETED, TOUCHED, GOAL_MISSED, GIVEN_UP)
"""Outcomes of missions that came to an end of their own."""


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

    A success touched nothing, completed its mission, and left the door within 2° of the target at the flight's end, a slide
    within 1.4 cm. Its tip stayed on the leaf for 90 % of the time, and never pushed it with more than 15 N.

    Args:
        summary: As `doorman.simulate` gives it.

    Returns:
        The judgement; the reasons are the mission's own where it gave up.
    """
    error, unit = final_error(summary), summary["unit"]
    reasons = []
    outcome = summary["outcome"]
    if summary["collisions"]:
        reasons.append(f"{summary['collisions']} contacts other than tip and leaf")
    if outcome not in (COMPLETED, TOUCHED):
        said = summary["reason"]
        reasons.append(f"{outcome}: {said}" if said else str(outcome))
    if not abs(error) < TOLERANCE[unit]:
        off = f"{error:+.1f}°" if unit == "deg" else f"{1e2 * error:+.1f} cm"
        reasons.append(f"the door ended {off} from the target")
    reasons += _contact(summary)
    safe = not summary["collisions"] and outcome in _ENDS
    return Judgement(not reasons, "; ".join(reasons), safe)


def _contact(summary: Mapping[str, Any]) -> list[str]:
    """What is wrong with the contact; a figure that a summary does not have is no fault."""
    share, push = summary.get("contact_fraction"), summary.get("max_push_force_n")
    reasons = []
    if share is not None and not share >= KEPT_CONTACT:
        reasons.append(f"the tip was on the leaf for {share:.1%} of the time, less than {KEPT_CONTACT:.1%}")
    if push is not None and not push <= _LARGEST_PUSH:
        reasons.append(f"the tip pushed with {push:.1f} N, more than {_LARGEST_PUSH:g} N")
    return reasons


def final_error(summary: Mapping[str, Any]) -> float:
    """Door's final angle minus target [deg], or a slide's opening [m], as its `unit` says; NaN if the summary has none."""
    error = summary["final_error"]
    return math.nan if error is None else float(error)


_TRUE_OF = {
    "the gripper does not hold": {SLIPPED, NEVER_CLOSED},
    "the wind": {WIND, DRAUGHT},
    "felt wind": {WIND, DRAUGHT},
    "the latch": {LATCHED},
    "the poses are too old": {LATE},
    "the poses are too noisy": {NOISY},
}
"""Words of a mission's reason, and of what one must be true."""
_STUCK = ("does not move on", "does not give way")
_MUST_TELL = {
    SLIPPED: ("the gripper",),
    NEVER_CLOSED: ("the gripper",),
    LATCHED: (*_STUCK, "the latch"),
    SEALED: (*_STUCK, "the seal"),
}
"""What alone keeps a door from being opened, and words of a reason that tells it."""


def told_truly(summary: Mapping[str, Any]) -> bool | None:
    """Compare the mission's reason with the truth."""
    causes, said = set(summary.get("true_causes") or ()), str(summary.get("reason") or "")
    named = [true for words, true in _TRUE_OF.items() if words in said]
    missing = [cause for cause in causes & set(_MUST_TELL) if not any(words in said for words in _MUST_TELL[cause])]
    if missing or any(not true & causes for true in named):
        return False
    return True if named or causes & set(_MUST_TELL) else None
