"""The true mass, centre of mass and inertia, by the motion under known forces; the planner goes on believing the URDF."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from urdf_variants import VEHICLE, write_massive

from doorman.exceptions import BackendError, ScenarioError
from doorman.scenario import SimulationSection
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


@pytest.mark.parametrize("massive", [False, True])
def test_the_centre_of_mass_is_elsewhere(flight, tmp_path, massive):
    offset, urdf = (0.02, -0.01, 0.03), arm_of(tmp_path, massive)
    told, true = (
        body(flight, vehicle__urdf=urdf, simulation__vehicle_mass=3.9, **more)
        for more in ({}, {"simulation__vehicle_com": offset})
    )
    assert told.plant.engine_model.body_subtreemass[1] == pytest.approx(3.9, abs=1e-4)
    places = [np.array(one.data.subtree_com[1]) for one in (told, true)]
    np.testing.assert_allclose(places[1] - places[0], offset, atol=1e-6)
    # a lift through O_B turns the vehicle towards its mass: nose down, and to the right
    rates = true.run(0.05, every=50)[-1].body_rates
    assert rates[1] > 0.02 and rates[0] > 0.01


def test_values_that_cannot_be_are_refused():
    with pytest.raises(ScenarioError, match=r"vehicle_com\.0.*equal to 1"):
        SimulationSection(vehicle_com=(3.0, 0.0, 0.0))
    with pytest.raises(ScenarioError, match="vehicle_mass"):
        SimulationSection(vehicle_mass=0.0)


def test_weaker_servos_give_way(flight):
    """A shoulder under a load of 1.5 N m at a tenth of its torque."""

    def sag(scale: float) -> float:
        vehicle = body(flight, simulation__servo_torque_scale=scale)
        limit = float(vehicle.model.vehicle.torque_limits[1])
        vehicle.data.qfrc_applied[vehicle.plant.arm_velocities[1]] = 0.5 * limit
        before = vehicle.simulator.truth().arm_angles[1]
        return abs(float(vehicle.run(0.2, every=200)[-1].arm_angles[1] - before))

    assert sag(1.0) < math.radians(1.0) < math.radians(5.0) < sag(0.2)


@pytest.mark.parametrize("massive", [False, True])
def test_the_arm_has_its_mass_and_the_vehicle_keeps_its_own(flight, tmp_path, massive):
    urdf = arm_of(tmp_path, massive)
    told, true = (body(flight, vehicle__urdf=urdf, **more) for more in ({}, {"simulation__arm_mass": 0.8}))
    masses = [np.array(one.plant.engine_model.body_mass) for one in (told, true)]
    assert masses[1].sum() == pytest.approx(masses[0].sum(), abs=1e-3)
    assert (masses[0] - masses[1]).max() == pytest.approx(0.8 - (0.5 if massive else 0.0), abs=1e-3)


def test_an_arm_that_is_heavier_than_the_vehicle_is_refused(flight):
    with pytest.raises(BackendError, match=r"simulation\.arm_mass"):
        body(flight, simulation__arm_mass=3.5)
