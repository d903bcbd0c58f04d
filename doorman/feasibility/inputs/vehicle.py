"""Findings about a vehicle's URDF: what it does not say, and what is assumed instead."""

from __future__ import annotations

from doorman.feasibility.report import Finding, Severity, graded
from doorman.kinematics.vehicles.rotor_layout import RING_RADIUS, RING_SIZE
from doorman.model import Model

_ROUNDING = 1e-3
"""Rounding of lengths in URDFs [m]."""
_MOST_NAMES = 12
"""Most names of links in a message."""


def vehicle_findings(model: Model) -> list[Finding]:
    """What is taken for granted about the vehicle."""
    return [_rotor_frames(model), *_rotor_disc(model), _standing_joints(model)]


def _rotor_frames(model: Model) -> Finding:
    """Without rotors in the URDF the simulator flies a ring of them, which the vehicle has to allow."""
    vehicle = model.vehicle
    count = len(vehicle.rotors)
    if count:
        message = f"the URDF has {count} rotors, {vehicle.max_thrust:.1f} N together"
        return Finding("rotor frames", Severity.OK, message, float(count), 1.0, "rotors")
    base, assumed = vehicle.names.base_link, vehicle.names.rotors.assume
    links = [link for link, at in vehicle.links.items() if at.joint == 0 and link != base]
    found = ", ".join(links[:_MOST_NAMES]) + (", …" if len(links) > _MOST_NAMES else "")
    message = (
        f"the URDF has no rotors with a thrust: {RING_SIZE} upright ones are assumed, {RING_RADIUS * vehicle.radius:.2f} m "
        f"from the base link's origin, every {360 // RING_SIZE}° from 30°, {vehicle.max_thrust:.1f} N together; "
        f"fixed to '{base}' it has the links {found or 'none'}"
    )
    advice = (
        f"joints 'rotor_1', 'rotor_2', … (or with a prefix, 'uav1/rotor_1') from link '{base}' to each rotor's frame, z up, with "
        '<axis xyz="0 0 ±1"/> for the sense and <limit effort> for the largest thrust [N]; vehicle.rotors.assume = true takes '
        "the assumed ones"
    )
    severity = Severity.WARNING if assumed else Severity.ERROR
    return Finding("rotor frames", severity, message, float(count), 1.0, "rotors", advice)


def _rotor_disc(model: Model) -> list[Finding]:
    """Whether the disc that planner and audit keep clear holds the propellers; nothing where the URDF shows none."""
    vehicle = model.vehicle
    reach = vehicle.propeller_reach
    if not reach > 0.0:
        return []
    ok = reach <= vehicle.radius + _ROUNDING
    verb = "covers" if ok else "does not cover"
    return [
        Finding(
            "rotor disc", graded(ok, Severity.WARNING),
            f"the disc of {vehicle.radius:.3f} m radius {verb} the propellers, which reach {reach:.3f} m",
            reach, vehicle.radius, "m",
            "" if ok else f"let a collision shape of link '{vehicle.names.base_link}' cover them, or raise vehicle.radius",
        )
    ]  # fmt: skip


def _standing_joints(model: Model) -> Finding:
    """Joints that are not of the arm, such as a gripper's fingers, stand at zero in every model."""
    names = model.vehicle.standing_joints
    message = f"{len(names)} joints of the vehicle beside the arm's could move"
    if names:
        message += f", and stand at zero: {', '.join(names)}"
    return Finding(
        "vehicle's joints", graded(not names, Severity.WARNING), message, float(len(names)), 0.0, "joints",
        'type="fixed" in the URDF for joints that stand still' if names else "",
    )  # fmt: skip
