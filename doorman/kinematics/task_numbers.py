"""Numbers of a door task: of vehicle, arm, contact and door."""

from __future__ import annotations

import math

from numpy.typing import ArrayLike

from doorman.kinematics.doors.door import Door
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.kinematics.vehicles.vehicle import Vehicle


def task_numbers(vehicle: Vehicle, door: Door, distance_from_hinge: float, height: float) -> Numbers:
    """What URDFs and contact say, SI units; a symbolic `Task` knows them by these names."""
    return Numbers(
        {
            "arm": ArmPattern.of(vehicle.arm)[1],
            "vehicle.mass": vehicle.mass,
            "vehicle.radius": vehicle.radius,
            "vehicle.max_thrust": vehicle.max_thrust,
            "contact.distance_from_hinge": distance_from_hinge,
            "contact.height": height,
            "contact.offset": door.contact_offset,
            "door.hinge_position": door.hinge_position,
            "door.azimuth": door.azimuth,
            "door.hand": door.hand,
            "door.into": door.into,
            "door.along": door.along,
            "door.closed": door.closed,
            "door.joint_per_angle": door.joint_rate(1.0),
            "door.opening_per_angle": door.opening_of(0.5 * math.pi + 1.0),
            "door.frame_depth": door.frame_depth,
            "door.frame_back": door.frame_back,
            "door.width": door.width,
            "door.height": door.height,
            "door.inertia": door.inertia,
            "door.moving_inertia": door.inertia,
            "door.damping": door.damping,
            "door.friction": door.friction,
            "door.friction_rate": door.friction_rate,
            "door.stiffness": door.stiffness,
            "door.rest_angle": door.rest_angle,
            "door.disturbance": door.closing_torque,
            **({} if door.frame_height is None else {"door.frame_height": door.frame_height}),
            **_axes(door),
        }
    )


def _axes(door: Door) -> dict[str, ArrayLike]:
    """Further numbers of a door that does not turn about a vertical: which there are says how its leaf moves."""
    if door.vertical:
        return {}
    numbers: dict[str, ArrayLike] = {"door.up": door.up, "door.weight": door.weight}
    if door.slides:
        numbers["door.slide"] = door.per_angle
    if door.panel is not None:
        numbers |= {"door.panel": door.from_doorway(door.panel[0]), "door.panel_distance": door.panel[1]}
    return numbers
