r"""Position limits for servos in velocity mode, which knows none: a rate is cut so that the joint can still stop.

.. math::
    r\,t + \frac{r^2}{2a} \le d \quad\Rightarrow\quad r \le a\left(\sqrt{t^2 + 2d/a} - t\right)

d is the distance to the limit, a the deceleration, t the time before the servo reacts. At and beyond the limit only the way
back is open.
"""

from __future__ import annotations

import math

from doorman.hardware.dynamixel.wire.units import VELOCITY_UNIT


def stopping_rate(distance: float, deceleration: float, delay: float) -> float:
    if not distance > 0.0:
        return 0.0
    return deceleration * (math.sqrt(delay * delay + 2.0 * distance / deceleration) - delay)


def allowed_rate(
    wanted: float, angle: float, lower: float, upper: float, largest: float, deceleration: float, delay: float
) -> float:
    """Rate that a joint may have: what is wanted, inside its rate limit, and so that it can stop at its limits."""
    if not (math.isfinite(wanted) and math.isfinite(angle)):
        return 0.0
    up = min(stopping_rate(upper - angle, deceleration, delay), largest)
    down = min(stopping_rate(angle - lower, deceleration, delay), largest)
    return max(min(wanted, up), -down)


class RateRounder:
    """Rounds rates to the servo's counts of 0.024 rad/s and carries the rest over to the next cycle."""

    # So a slow joint moves at its mean rate instead of standing still or running too fast. Nothing is carried over a stop.

    def __init__(self, n: int) -> None:
        self._rests = [0.0] * n

    def round(self, joint: int, rate: float) -> int:
        if rate == 0.0:
            self._rests[joint] = 0.0
            return 0
        wanted = rate / VELOCITY_UNIT + self._rests[joint]
        counts = round(wanted)
        self._rests[joint] = max(min(wanted - counts, 0.5), -0.5)
        return counts if counts * rate > 0.0 else 0

    def clear(self) -> None:
        self._rests = [0.0] * len(self._rests)
