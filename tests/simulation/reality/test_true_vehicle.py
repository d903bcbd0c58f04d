"""The true mass, centre of mass and inertia, by the motion under known forces; the planner goes on believing the URDF."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from urdf_variants import VEHICLE, write_massive

from doorman.simulation import Disturbance

HOVER = 3.0 * 9.81


def body(flight, **true):
    """Vehicle alone in the air."""
    return flight(contact__kind="push", away=True, **true)


def still(flight):
    """With rotors that stand and make nothing."""
    flight.simulator.set_rotors(np.zeros(6))
    flight.data.act[:] = 0.0
    return flight


@pytest.mark.parametrize("mass", [2.4, 3.6])
def test_hover_thrust_lifts_a_lighter_vehicle_and_drops_a_heavier_one(flight, mass):
    vehicle = body(flight, simulation__vehicle_mass=mass)
    assert vehicle.model.vehicle.mass == pytest.approx(3.0), "the planner is told the URDF's"
    velocity = vehicle.run(0.3, every=300)[-1].velocity
    assert velocity[2] == pytest.approx((HOVER / mass - 9.81) * 0.3, rel=0.01)


def test_inertia_goes_with_the_mass_and_by_its_own_scale(flight):
    """Angular acceleration about z under a torque, with rotors that stand."""

    def rate(**true) -> float:
        vehicle = still(body(flight, disturbance=lambda time: Disturbance(torque=(0.0, 0.0, 0.2)), **true))
        return float(vehicle.run(0.1, every=100)[-1].body_rates[2])

    told = rate()
    assert rate(simulation__vehicle_mass=4.5) == pytest.approx(told / 1.5, rel=0.01)
    assert rate(simulation__vehicle_inertia_scale=1.3) == pytest.approx(told / 1.3, rel=0.03)


def arm_of(folder: Path, massive: bool) -> str:
    """The shipped vehicle, or one whose third servo weighs half a kilogram."""
    return str(write_massive(folder / "arm.urdf", {"servo_3": 0.5}) if massive else VEHICLE)
