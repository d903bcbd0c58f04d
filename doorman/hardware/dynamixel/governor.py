r"""From the controller's rates to goal velocities: limits of rate and angle, then whole counts.

Servos in velocity mode know no position limits, so a rate is cut such that the joint can still stop:

.. math::
    r\,t + \frac{r^2}{2a} \le d \quad\Rightarrow\quad r \le a\left(\sqrt{t^2 + 2d/a} - t\right)

d is the distance to the limit, a the deceleration, t the time before the servo reacts. At and beyond the limit only the way
back is open.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.wire.registers import VELOCITY_UNIT


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


class RateGovernor:
    def __init__(self, config: ServoConfig, velocity_limits: Sequence[int]) -> None:
        lower, upper, rates = config.limits
        self._lower = [float(value) + config.limit_margin for value in lower]
        self._upper = [float(value) - config.limit_margin for value in upper]
        self._largest_counts = [
            min(math.floor(float(rate) / VELOCITY_UNIT), limit)
            for rate, limit in zip(rates[: config.n_joints], velocity_limits[: config.n_joints], strict=True)
        ]
        self._config = config
        self._rests = [0.0] * config.n_joints  # of every joint's rate, which no whole count has made up for [count]

    def counts(self, rates: Sequence[float], angles: Sequence[float], ages: Sequence[float]) -> list[int]:
        counts = []
        for joint, sign in enumerate(self._config.signs[: self._config.n_joints]):
            largest = self._largest_counts[joint]
            rate = allowed_rate(
                rates[joint], angles[joint], self._lower[joint], self._upper[joint], largest * VELOCITY_UNIT,
                self._config.deceleration, self._config.reaction_time + ages[joint],
            )  # fmt: skip
            counts.append(sign * max(min(self._rounded(joint, rate), largest), -largest))
        return counts

    def halt(self) -> list[int]:
        """Goal velocities of a stop; nothing is carried over it."""
        self._rests = [0.0] * len(self._rests)
        return [0] * self._config.n_joints

    def _rounded(self, joint: int, rate: float) -> int:
        """Whole counts of a rate. What is left goes into the next cycle, so that a slow joint keeps its mean rate."""
        if rate == 0.0:
            self._rests[joint] = 0.0
            return 0
        wanted = rate / VELOCITY_UNIT + self._rests[joint]
        counts = round(wanted)
        self._rests[joint] = max(min(wanted - counts, 0.5), -0.5)
        return counts if counts * rate > 0.0 else 0
