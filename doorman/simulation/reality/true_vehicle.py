"""The simulated vehicle: heavier or lighter than its URDF says, with its mass elsewhere, or spread otherwise."""

from __future__ import annotations

from typing import Any

import numpy as np

from doorman.exceptions import BackendError
from doorman.model import Model

_MASSLESS, _BALL = 1e-3, 0.03
"""An arm that is lighter has no mass in the URDF [kg]; radius of the balls that stand for its links [m]."""
_LEAST_SHARE = 0.05
"""Least share of the vehicle's mass in the base link if that moves the centre of mass."""


def make_true(vehicle: Any, base: Any, model: Model) -> None:
    """Give the vehicle its true mass, centre of mass and inertia."""
    true = model.scenario.simulation
    if true.vehicle_mass is not None:
        scale_mass(vehicle.bodies, true.vehicle_mass / model.vehicle.mass)
    if true.arm_mass is not None:
        set_arm_mass(vehicle, base, model, true.arm_mass)
    if true.vehicle_inertia_scale != 1.0:
        base.fullinertia = [true.vehicle_inertia_scale * value for value in base.fullinertia]
    if any(true.vehicle_com):
        mass = model.vehicle.mass if true.vehicle_mass is None else true.vehicle_mass
        if base.mass < _LEAST_SHARE * mass:
            raise BackendError(
                "the base link is too light to move the centre of mass", file=model.vehicle.urdf,
                field="simulation.vehicle_com", given=f"{base.mass:g} of {mass:g} kg", allowed="a heavier base link",
            )  # fmt: skip
        base.ipos = np.asarray(base.ipos) + mass / base.mass * np.asarray(true.vehicle_com)


def set_arm_mass(vehicle: Any, base: Any, model: Model, mass: float) -> None:
    """Give the arm its true mass, and take it from the base link."""
    carried = (joint.parent for joint in vehicle.joints if joint.name in model.vehicle.joint_names[:1])
    moved = [part for link in carried for part in (link, *link.find_all("body"))]
    nominal = sum(part.mass for part in moved)
    left = base.mass - (mass - nominal)
    if not moved or left < _LEAST_SHARE * base.mass:
        raise BackendError(
            "the arm cannot have this mass", file=model.vehicle.urdf, field="simulation.arm_mass", given=mass,
            allowed=f"an arm, and less than {nominal + (1.0 - _LEAST_SHARE) * base.mass:g} kg",
        )  # fmt: skip
    scale_mass((base,), left / base.mass)
    if nominal > _MASSLESS:
        scale_mass(moved, mass / nominal)
        return
    for part in moved:
        part.mass, part.explicitinertial = mass / len(moved), True
        part.ipos = [0.0, 0.0, 0.0]
        part.fullinertia = [*[0.4 * part.mass * _BALL**2] * 3, 0.0, 0.0, 0.0]


def scale_mass(bodies: Any, ratio: float) -> None:
    """Scale mass and inertia of some bodies."""
    for part in bodies:
        part.mass *= ratio
        part.fullinertia = [ratio * value for value in part.fullinertia]
