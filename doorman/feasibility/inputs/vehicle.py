"""Findings about a vehicle's URDF: what it does not say, and what is assumed instead."""

from __future__ import annotations

from collections.abc import Sequence

from doorman.feasibility.report import Finding, Severity, found, warning_if
from doorman.kinematics.urdf.structure import ROUNDING
from doorman.kinematics.vehicles.rotor_layout import RING_RADIUS, RING_SIZE
from doorman.model import Model

_MOST_NAMES = 12
"""Most names of links in a message."""


def vehicle_findings(model: Model) -> list[Finding]:
    """What is taken for granted about the vehicle."""
    joints = standing_joints("vehicle's joints", "of the vehicle beside the arm's", model.vehicle.standing_joints)
    return [_rotor_frames(model), *_rotor_disc(model), joints]


def standing_joints(name: str, which: str, joints: Sequence[str], more: str = "") -> Finding:
    """Joints that no model moves, such as a gripper's fingers, stand at zero."""
    message = f"{len(joints)} joints {which} could move" + (
        f", and stand at zero: {', '.join(joints)}" if joints else ""
    )
    advice = f'type="fixed" in the URDF for joints that stand still{more}'
    return found(name, not joints, message, float(len(joints)), 0.0, "joints", advice, Severity.WARNING)


def _rotor_frames(model: Model) -> Finding:
    """Without rotors in the URDF the simulator flies a ring of them, which the vehicle has to allow."""
    vehicle, base = model.vehicle, model.vehicle.names.base_link
    count = len(vehicle.rotors)
    message = f"the URDF has {count} rotors, {vehicle.max_thrust:.1f} N together"
    if not count:
        links = [link for link, at in vehicle.links.items() if at.joint == 0 and link != base]
        named = ", ".join(links[:_MOST_NAMES]) + (", …" if len(links) > _MOST_NAMES else "")
        message = (
            f"the URDF has no rotors with a thrust: {RING_SIZE} upright ones are assumed, {RING_RADIUS * vehicle.radius:.2f} m "
            f"from the base link's origin, every {360 // RING_SIZE}° from 30°, {vehicle.max_thrust:.1f} N together; "
            f"fixed to '{base}' it has the links {named or 'none'}"
        )
    advice = (
        f"joints 'rotor_1', 'rotor_2', … (or with a prefix, 'uav1/rotor_1') from link '{base}' to each rotor's frame, z up, with "
        '<axis xyz="0 0 ±1"/> for the sense and <limit effort> for the largest thrust [N]; vehicle.rotors.assume = true takes '
        "the assumed ones"
    )
    worse = warning_if(vehicle.names.rotors.assume)
    return found("rotor frames", count > 0, message, float(count), 1.0, "rotors", advice, worse)


def _rotor_disc(model: Model) -> list[Finding]:
    """Whether the disc that planner and audit keep clear holds the propellers; nothing where the URDF shows none."""
    vehicle, reach = model.vehicle, model.vehicle.propeller_reach
    if not reach > 0.0:
        return []
    ok = reach <= vehicle.radius + ROUNDING
    return [found(
        "rotor disc", ok,
        f"the disc of {vehicle.radius:.3f} m radius {'covers' if ok else 'does not cover'} the propellers, which reach "
        f"{reach:.3f} m",
        reach, vehicle.radius, "m",
        f"let a collision shape of link '{vehicle.names.base_link}' cover them, or raise vehicle.radius", Severity.WARNING,
    )]  # fmt: skip
