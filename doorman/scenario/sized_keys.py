"""Keys whose default grows with the vehicle: see `sized`."""

from __future__ import annotations

from collections.abc import Mapping

FORCE, TORQUE, LENGTH, SPEED, RATE = "force", "torque", "length", "speed", "rate"
RESISTANCE, STIFFNESS, HINGE = "resistance", "stiffness", "hinge"


_ESTIMATION = {
    FORCE: "tip_force contact.pull noise.wind start.wind",
    LENGTH: "contact.gap start.face",
    SPEED: "noise.velocity",
    STIFFNESS: "contact.stiffness",
    RESISTANCE: "noise.resistance",
    HINGE: "hinge.damping hinge.damping_deviation hinge.friction hinge.friction_deviation hinge.stiffness "
    "hinge.stiffness_deviation",
}
SIZED: Mapping[str, str] = {
    "control.max_push": FORCE,
    "control.max_disturbance": FORCE,
    "control.max_door_disturbance": TORQUE,
    "planner.margin": LENGTH,
    **{f"estimation.{name}": unit for unit, names in _ESTIMATION.items() for name in names.split()},
}
"""Unit by dotted key."""
