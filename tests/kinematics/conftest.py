"""Fixtures of the kinematics' tests."""

from __future__ import annotations

import pytest
from urdf_variants import DOOR, VEHICLE, robot_data_vehicle, write_arm_of

from doorman.kinematics.coupling import Coupling
from doorman.kinematics.doors.door import Door
from doorman.kinematics.vehicles.vehicle import Vehicle


@pytest.fixture(scope="package", params=["shipped", "borinot_flying_arm_2", "hextilt_flying_arm_5", 1, 3, 7])
def coupling(request, tmp_path_factory):
    """Vehicles of others, and arms of so many joints with odd axes, at the shipped door."""
    kind = request.param
    if kind == "shipped":
        vehicle = Vehicle(VEHICLE)
    elif isinstance(kind, int):
        path = tmp_path_factory.mktemp("arm") / "odd.urdf"
        vehicle = Vehicle(write_arm_of(path, kind, odd_axes_seed=kind))
    else:
        vehicle = Vehicle(*robot_data_vehicle(kind))
    return Coupling(vehicle, Door(DOOR), 0.65, 0.9)
