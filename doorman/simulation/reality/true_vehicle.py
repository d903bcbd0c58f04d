"""The simulated vehicle: heavier or lighter than its URDF says, with its mass elsewhere, or spread otherwise."""

from __future__ import annotations

from typing import Any

import numpy as np

from doorman.exceptions import BackendError
from doorman.model import Model

_LEAST_SHARE = 0.05
"""Least share of the vehicle's mass in the base link if that moves the centre of mass."""


def make_true(vehicle: Any, base: Any, model: Model) -> None:
    """Give the vehicle its true mass, centre of mass and inertia."""
    true = model.scenario.simulation
    if true.vehicle_mass is not None:
        scale_mass(vehicle.bodies, true.vehicle_mass / model.vehicle.mass)
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


def scale_mass(bodies: Any, ratio: float) -> None:
    """Scale mass and inertia of some bodies."""
    for part in bodies:
        part.mass *= ratio
        part.fullinertia = [ratio * value for value in part.fullinertia]
