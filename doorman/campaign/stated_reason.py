"""Whether a mission that failed stated the true reason, as far as the simulator knows it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from doorman.simulation.reality.causes import DRAUGHT, LATCHED, LATE, NEVER_CLOSED, NOISY, SEALED, SLIPPED, WIND

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
