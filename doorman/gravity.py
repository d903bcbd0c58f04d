"""The acceleration of free fall, and what masses weigh by it."""

from __future__ import annotations

GRAVITY = 9.81
"""Standard gravity, as MuJoCo and the autopilots' simulators have it [m/s²]."""


def weight_of(mass: float) -> float:
    """Weight m g of a mass [N]; of 1 kg, the acceleration of free fall [m/s²]."""
    return mass * GRAVITY
