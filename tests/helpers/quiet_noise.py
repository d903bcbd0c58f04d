"""Simulated sensors without noise."""

from __future__ import annotations

from typing import ClassVar

from doorman.scenario import NoiseSection


class _Quiet(NoiseSection):
    velocity: ClassVar = 0.0
    body_rates: ClassVar = 0.0
    arm_angles: ClassVar = 0.0
    arm_rates: ClassVar = 0.0


def quiet_noise() -> NoiseSection:
    """Noise of none."""
    return _Quiet(position=0.0, attitude=0.0)
