"""Where the centre of mass is and how it moves, seen from O_B: what forces accelerate is not O_B where the arm has mass."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.control.observers.vehicle_observer import AT_THE_ORIGIN
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.signals import Measurement

Array = NDArray[np.float64]


def center_of_mass(vehicle: Vehicle, measured: Measurement) -> tuple[Array, Array]:
    r"""Place :math:`R\,c` and velocity :math:`R(\Omega\times c + J_c\dot H)` of the centre of mass from O_B."""
    if vehicle.bodies.balanced:
        return AT_THE_ORIGIN
    rotation, center = rotation_body_to_world(measured.attitude), vehicle.center_of_mass(measured.arm_angles)
    moved = vehicle.center_of_mass_jacobian(measured.arm_angles) @ measured.arm_rates
    return rotation @ center, rotation @ (np.cross(measured.body_rates, center) + moved)
