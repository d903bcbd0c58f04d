"""Keys whose default grows with the vehicle: see `sized`."""

from __future__ import annotations

from collections.abc import Mapping

FORCE, TORQUE, LENGTH, HINGE = "force", "torque", "length", "hinge"
SIZED: Mapping[str, str] = {
    "control.max_push": FORCE,
    "control.max_disturbance": FORCE,
    "control.max_door_disturbance": TORQUE,
    "planner.margin": LENGTH,
    "mission.touch_force": FORCE,
    "estimation.torque_deviation": HINGE,
    "estimation.damping": HINGE,
    "estimation.friction": HINGE,
    "estimation.stiffness": HINGE,
    "estimation.push_noise": FORCE,
    "estimation.contact.touched_above": FORCE,
    "estimation.contact.certain_above": FORCE,
    "estimation.contact.arrived_above": FORCE,
    "estimation.contact.lost_below": FORCE,
}
"""Unit by dotted key."""
