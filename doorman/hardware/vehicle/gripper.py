"""The gripper: one more servo on the arm's bus, in velocity mode, between open at 0 and closed."""

from __future__ import annotations

OPEN, SHUT = 0.0, 0.8
"""Angles at which the fingers are wide open and pressed together [rad]."""
CLOSED = 0.6
"""Beyond this angle the fingers hold what is between them [rad]."""
LOWER, UPPER = -0.05, SHUT + 0.05
"""Limits of the servo [rad]."""
RATE = 2.0
"""Of closing and opening [rad/s]."""
_GAIN = 10.0
_DEAD_BAND = 0.02


def gripper_rate(angle: float, closed: bool) -> float:
    """Rate that brings the fingers to where they are wanted.

    Args:
        angle: Of the gripper's servo [rad].
        closed: Whether to hold.

    Returns:
        [rad/s].
    """
    error = (SHUT if closed else OPEN) - angle
    return 0.0 if abs(error) < _DEAD_BAND else min(max(_GAIN * error, -RATE), RATE)
