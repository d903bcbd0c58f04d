"""Keys whose default grows with the vehicle: see `sized`."""

from __future__ import annotations

from collections.abc import Mapping

FORCE, TORQUE, LENGTH, SPEED, RATE = "force", "torque", "length", "speed", "rate"
RESISTANCE, STIFFNESS, HINGE = "resistance", "stiffness", "hinge"
_AT_THE_LEAF = {
    FORCE: "contact.pull noise.wind noise.jump noise.draught start.wind start.draught start.friction",
    LENGTH: "contact.gap contact.inside switch.near switch.reach noise.face start.face start.reach",
    SPEED: "contact.gap_rate contact.slip_rate noise.velocity noise.thrown_along start.velocity",
    RATE: "noise.wind_turn noise.rate noise.throw start.wind_turn start.joint_rate hinge.moves",
    STIFFNESS: "contact.stiffness",
    RESISTANCE: "contact.more noise.resistance start.resistance",
    HINGE: "hinge.damping hinge.damping_deviation hinge.friction hinge.friction_deviation hinge.stiffness "
    "hinge.stiffness_deviation hinge.by_chance",
}
SIZED: Mapping[str, str] = {
    "control.max_push": FORCE,
    "control.max_disturbance": FORCE,
    "control.max_door_disturbance": TORQUE,
    "planner.margin": LENGTH,
    "estimation.tip_force": FORCE,
    **{f"estimation.{name}": unit for unit, names in _AT_THE_LEAF.items() for name in names.split()},
}
"""Unit by dotted key."""
