"""Keys whose default grows with the vehicle: see `sized`."""

from __future__ import annotations

from collections.abc import Mapping

FORCE, TORQUE, LENGTH = "force", "torque", "length"
SIZED: Mapping[str, str] = {
    "control.max_push": FORCE,
    "control.max_disturbance": FORCE,
    "control.max_door_disturbance": TORQUE,
    "planner.margin": LENGTH,
}
"""Unit by dotted key."""
