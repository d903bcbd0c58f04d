"""The way home of the emulated autopilots' failsafes, with time made up; and the pilot's sticks."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from autopilot_sandbox import Sandbox, offboard

from doorman.rig.emulators.autopilot import ardupilot, px4
from doorman.rig.emulators.autopilot.control import Task


def flown_home(sandbox: Sandbox, seconds: float = 20.0) -> np.ndarray:
    """Where a vehicle that does what it is told has been, until it is told to land, every 20 ms."""
    places = []
    for _ in range(round(seconds / 0.02)):
        demand = sandbox.step(0.02)
        if demand.task is Task.LAND:
            break
        assert demand.task is Task.POSITION
        sandbox.position = demand.position.copy()
        places.append(sandbox.position)
    assert demand.task is Task.LAND, "it does not arrive"
    return np.array(places)


def away(sandbox: Sandbox, height: float = 1.2) -> None:
    """In the air, 1.5 m from where it was armed."""
    assert sandbox.brain.request_arming(True, False) == 0
    sandbox.brain.landed = False
    sandbox.position = np.array([1.2, -0.9, height])


@pytest.mark.parametrize(
    ("values", "most"),
    [({"RTL_RETURN_ALT": 0.0, "RTL_CONE_ANG": 0}, 1.2), ({}, 3.0), ({"NAV_ACC_RAD": 0.5}, 1.5),
     ({"NAV_ACC_RAD": 0.5, "RTL_RETURN_ALT": 1.3}, 1.3), ({"RTL_CONE_ANG": 0}, 60.0)],
)  # fmt: skip
def test_px4_returns_as_high_as_its_parameters_say_and_lands_at_home(vehicle_px4, values, most):
    for name, value in values.items():
        vehicle_px4.brain.parameters[name] = value
    offboard(vehicle_px4)
    away(vehicle_px4)
    vehicle_px4.brain.pilot_mode("return")
    places = flown_home(vehicle_px4)
    assert places[:, 2].max() == pytest.approx(most)
    assert np.linalg.norm(places[-1, :2]) < 0.2
    climbing = places[:, 2] < most - 0.1
    assert np.allclose(places[climbing, :2], [1.2, -0.9]), "up before it leaves"
    assert np.abs(np.diff(places[:, :2], axis=0)).max() < 0.04, "no jump"


@pytest.mark.parametrize(
    ("values", "most"),
    [({"RTL_ALT": 30}, 1.2), ({"RTL_ALT": 0, "RTL_CONE_SLOPE": 0}, 1.2), ({}, 4.5), ({"RTL_CONE_SLOPE": 0}, 15.0),
     ({"RTL_ALT": 30, "RTL_CLIMB_MIN": 50}, 1.7)],
)  # fmt: skip
def test_ardupilot_returns_as_high_as_its_parameters_say_and_lands_at_home(vehicle_ardupilot, values, most):
    for name, value in {"FS_GCS_ENABLE": 1, "RTL_LOIT_TIME": 0, **values}.items():
        vehicle_ardupilot.brain.parameters[name] = value
    away(vehicle_ardupilot)
    vehicle_ardupilot.station_age = 6.0
    places = flown_home(vehicle_ardupilot)
    assert vehicle_ardupilot.brain.failsafe
    assert places[:, 2].max() == pytest.approx(most)
    assert np.linalg.norm(places[-1, :2]) < 0.2


def test_px4_with_a_cone_sinks_on_its_way_home_at_a_low_return_altitude(vehicle_px4):
    vehicle_px4.brain.parameters["RTL_RETURN_ALT"] = 0.0
    away(vehicle_px4)
    vehicle_px4.brain.pilot_mode("return")
    assert flown_home(vehicle_px4)[0, 2] == 0.0


def test_px4_turns_near_home_unless_told_to_keep_its_heading(vehicle_px4):
    away(vehicle_px4)
    vehicle_px4.brain.home = replace(vehicle_px4.brain.home, yaw=1.0)
    values = vehicle_px4.brain.parameters
    headings = []
    for least, mode in ((10.0, 5), (0.5, 5), (0.5, 0)):
        values["RTL_MIN_DIST"], values["MPC_YAW_MODE"], values["RTL_CONE_ANG"] = least, mode, 0
        values["RTL_RETURN_ALT"] = 0.0
        vehicle_px4.brain.pilot_mode("position")
        vehicle_px4.brain.pilot_mode("return")
        vehicle_px4.step(0.1)
        headings.append(vehicle_px4.step(0.1).yaw)
    assert headings == pytest.approx([1.0, 0.0, math.atan2(0.9, -1.2)])


def test_px4_without_a_place_on_earth_neither_returns_nor_loiters(vehicle_px4):
    vehicle_px4.on_earth = False
    vehicle_px4.brain.parameters["COM_OBL_RC_ACT"] = 3
    offboard(vehicle_px4)
    away(vehicle_px4)
    for name in ("return", "loiter"):
        vehicle_px4.brain.pilot_mode(name)
        assert vehicle_px4.brain.mode == px4.OFFBOARD
    assert "not available" in vehicle_px4.brain.texts[-1][1]
    assert vehicle_px4.step(3.0).task is Task.LAND, "what it does instead"


def test_ardupilot_with_a_final_altitude_does_not_land(vehicle_ardupilot):
    away(vehicle_ardupilot)
    vehicle_ardupilot.brain.parameters["RTL_ALT"], vehicle_ardupilot.brain.parameters["RTL_ALT_FINAL"] = 30, 100
    vehicle_ardupilot.brain.pilot_mode("return")
    with pytest.raises(AssertionError, match="does not arrive"):
        flown_home(vehicle_ardupilot, 60.0)
    assert vehicle_ardupilot.brain.home.distance(vehicle_ardupilot.position) < 0.1


def test_ardupilot_waits_over_home_before_it_lands(vehicle_ardupilot):
    away(vehicle_ardupilot)
    vehicle_ardupilot.brain.parameters["RTL_ALT"] = 30
    vehicle_ardupilot.brain.pilot_mode("return")
    assert len(flown_home(vehicle_ardupilot)) * 0.02 > 5.0


@pytest.mark.parametrize("fixture", ["vehicle_px4", "vehicle_ardupilot"])
def test_the_sticks_move_a_vehicle_whose_pilot_holds_it(request, fixture):
    sandbox = request.getfixturevalue(fixture)
    away(sandbox)
    sandbox.brain.sticks = np.array([-0.5, 0.0, 0.0])
    sandbox.brain.pilot_mode("altitude")
    assert sandbox.step(0.1).task is Task.POSITION
    sandbox.brain.pilot_mode("position")
    demand = sandbox.step(0.1)
    assert demand.task is Task.VELOCITY and demand.velocity.tolist() == [-0.5, 0.0, 0.0]
    sandbox.position[0] = 0.3
    sandbox.brain.sticks = np.zeros(3)
    demand = sandbox.step(0.1)
    assert demand.task is Task.POSITION and demand.position[0] == 0.3, "where the sticks were let go of"


@pytest.mark.parametrize(("options", "mode"), [(16, ardupilot.RETURN), (24, ardupilot.LAND)])
def test_a_landing_of_ardupilot_without_its_station_goes_on_only_if_told_to(vehicle_ardupilot, options, mode):
    brain = vehicle_ardupilot.brain
    brain.parameters["FS_GCS_ENABLE"], brain.parameters["FS_OPTIONS"] = 1, options
    away(vehicle_ardupilot)
    assert brain.request_land() == 0
    vehicle_ardupilot.station_age = 30.0
    vehicle_ardupilot.step(0.02)
    assert brain.mode == mode
