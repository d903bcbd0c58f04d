"""From the controller's rates to goal velocities: limits of rate and angle, then whole counts."""

from __future__ import annotations

import math
from collections.abc import Sequence

from doorman.hardware.dynamixel.braking import RateRounder, allowed_rate
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.wire.units import VELOCITY_UNIT


class RateGovernor:
    """Decides how fast every joint may turn."""

    def __init__(self, config: ServoConfig, velocity_limits: Sequence[int]) -> None:
        lower, upper, rates = config.limits
        self._lower = [float(value) + config.limit_margin for value in lower]
        self._upper = [float(value) - config.limit_margin for value in upper]
        self._largest_counts = [
            min(math.floor(float(rate) / VELOCITY_UNIT), limit)
            for rate, limit in zip(rates[: config.n_joints], velocity_limits[: config.n_joints], strict=True)
        ]
        self._config = config
        self._rounder = RateRounder(config.n_joints)

    def counts(self, rates: Sequence[float], angles: Sequence[float], ages: Sequence[float]) -> list[int]:
        counts = []
        for joint, sign in enumerate(self._config.signs[: self._config.n_joints]):
            largest = self._largest_counts[joint]
            rate = allowed_rate(
                rates[joint], angles[joint], self._lower[joint], self._upper[joint], largest * VELOCITY_UNIT,
                self._config.deceleration, self._config.reaction_time + ages[joint],
            )  # fmt: skip
            counts.append(sign * max(min(self._rounder.round(joint, rate), largest), -largest))
        return counts

    def halt(self) -> list[int]:
        """Goal velocities of a stop; nothing is carried over it."""
        self._rounder.clear()
        return [0] * self._config.n_joints
