"""The gripper: one more servo on the arm's bus, whose current closes the fingers against a spring that opens them.

A spring opens them whatever has failed: the bus, the servo, the program or the power.
"""

from __future__ import annotations

OPEN, SHUT = 0.0, 0.8
"""Angles at which the fingers are wide open and pressed together [rad]."""
CLOSED = 3 * SHUT / 4
"""Least angle at which the fingers hold what is between them [rad]."""
HALF_OPEN = CLOSED / 2
"""Largest angle at which they have certainly let go [rad]."""
LOWER, UPPER = -SHUT / 16, SHUT + SHUT / 16
"""Limits of the servo [rad]."""
RATE = 3.0
"""Fastest that they move [rad/s]."""
CLOSING_CURRENT = 0.6
"""Holds [A]."""
OPENING_CURRENT = -CLOSING_CURRENT / 2
"""Helps the spring [A]."""
CLOSES_WITHIN = 1.5
"""Time in which the fingers have closed [s]."""
OPENS_WITHIN = 1.0
"""Time in which the spring has opened the fingers of a silent servo, its watchdog included [s]."""
_DEAD_BAND = SHUT / 8
"""Angle up to which they count as wide open [rad]."""


def gripper_current(angle: float, closed: bool) -> float:
    """Current that brings the fingers to where they are wanted."""
    if closed:
        return CLOSING_CURRENT
    return OPENING_CURRENT if angle > OPEN + _DEAD_BAND else 0.0
