"""Keys whose default grows with the vehicle: see `sized`."""

from __future__ import annotations

from collections.abc import Mapping

FORCE, TORQUE, LENGTH, SPEED, RATE = "force", "torque", "length", "speed", "rate"
RESISTANCE, STIFFNESS = "resistance", "stiffness"

SIZED: Mapping[str, str] = {
    "control.max_push": FORCE,
    "control.max_door_disturbance": TORQUE,
    "planner.margin": LENGTH,
    "estimation.noise.wind": FORCE,
}
"""Unit by dotted key."""
