"""Rules of the emulated autopilot that adapter and rig rely on, with time made up."""

from __future__ import annotations

import math

import numpy as np
import pytest
from autopilot_sandbox import LEVEL, Sandbox
from pixhawk_rig import NO
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot.control import Task
from doorman.rig.emulators.autopilot.dialects import DENIED, FAILED, TEMPORARILY_REJECTED, UNSUPPORTED
from doorman.rig.emulators.autopilot.estimator import Estimator, PlantTruth

TILTED = np.array([math.cos(0.2), math.sin(0.2), 0.0, 0.0])


@pytest.fixture(params=["px4", "ardupilot"])
def vehicle(request: pytest.FixtureRequest) -> Sandbox:
    """Both in turn."""
    return request.getfixturevalue(f"vehicle_{request.param}")


# ------------------------------------------------------------ modes and arming


def test_px4_acknowledges_offboard_without_a_stream_and_does_not_change(vehicle_px4):
    before = vehicle_px4.brain.mode
    assert vehicle_px4.request("companion") == 0 and vehicle_px4.brain.mode == before
    vehicle_px4.fly()


@pytest.mark.parametrize(("limit", "waited", "entered"), [(1.0, 0.8, True), (1.0, 1.2, False), (0.2, 0.4, False)])
def test_px4_takes_one_setpoint_for_a_stream_as_long_as_it_is_new(vehicle_px4, limit, waited, entered):
    vehicle_px4.parameters["COM_OF_LOSS_T"] = limit
    vehicle_px4.hold()
    vehicle_px4.step(waited)
    vehicle_px4.request("companion")
    assert vehicle_px4.brain.is_in("companion") is entered


def test_px4_in_the_air_refuses_a_mode_that_it_cannot_fly(vehicle_px4):
    vehicle_px4.arm()
    assert vehicle_px4.request("companion") == TEMPORARILY_REJECTED, "no stream"
    vehicle_px4.on_earth = False
    vehicle_px4.step(0.1)
    assert vehicle_px4.request("return") == TEMPORARILY_REJECTED, "no home"
    assert vehicle_px4.request("land") == 0 and vehicle_px4.brain.request_mode(77) == DENIED
    assert vehicle_px4.brain.request_take_off(2.0) == UNSUPPORTED


def test_ardupilot_needs_a_position_for_guided(vehicle_ardupilot):
    vehicle_ardupilot.valid = False
    vehicle_ardupilot.step(0.1)
    assert vehicle_ardupilot.request("companion") == FAILED and vehicle_ardupilot.brain.is_in("stabilize")


def test_the_pilot_wins(vehicle):
    vehicle.fly()
    vehicle.brain.pilot_mode("position")
    vehicle.step(1.0, vehicle.hold)
    assert vehicle.brain.is_in("position")
    vehicle.brain.sticks = (-0.5, 0.0, 0.0)
    assert vehicle.step(0.1).velocity.tolist() == [-0.5, 0.0, 0.0]
    vehicle.brain.sticks = (0.0, 0.0, 0.0)
    assert vehicle.step(0.1).task is Task.POSITION
    with pytest.raises(ValueError, match="unknown mode"):
        vehicle.brain.pilot_mode("warp")


def test_neither_arms_without_a_position_or_where_a_test_refuses(vehicle):
    refusal = vehicle.brain.dialect.refusal
    vehicle.valid = False
    vehicle.step(0.1)
    assert vehicle.arm() == refusal
    vehicle.valid = True
    vehicle.step(0.1)
    vehicle.brain.refusal = "PreArm: hatch open"
    assert vehicle.arm() == refusal and vehicle.brain.texts[-1][1] == "PreArm: hatch open"
    vehicle.brain.refusal = None
    assert vehicle.arm() == 0 and vehicle.brain.armed


def test_px4_does_not_arm_in_offboard_without_a_stream_or_without_a_station_that_it_needs(vehicle_px4):
    vehicle_px4.step(0.6, vehicle_px4.hold)
    vehicle_px4.request("companion")
    vehicle_px4.step(1.5)
    assert vehicle_px4.arm() == TEMPORARILY_REJECTED
    vehicle_px4.parameters["NAV_DLL_ACT"], vehicle_px4.station_age = 2, math.inf
    vehicle_px4.step(0.1, vehicle_px4.hold)
    assert vehicle_px4.arm() == TEMPORARILY_REJECTED and "GCS" in vehicle_px4.brain.texts[-1][1]


def test_ardupilot_waits_for_its_gyros(vehicle_ardupilot):
    vehicle_ardupilot.now = 21.0
    vehicle_ardupilot.step(0.1)
    assert vehicle_ardupilot.arm() == FAILED
    vehicle_ardupilot.step(1.0)
    assert vehicle_ardupilot.arm() == 0


def test_who_does_not_take_off_is_disarmed(vehicle):
    vehicle.arm()
    vehicle.step(9.0)
    assert vehicle.brain.armed
    vehicle.step(2.0)
    assert not vehicle.brain.armed


# ------------------------------------------------------------ setpoints


def test_ardupilot_takes_off_by_command_only(vehicle_ardupilot):
    brain = vehicle_ardupilot.brain
    assert brain.request_take_off(1.0) == FAILED, "disarmed"
    vehicle_ardupilot.request("companion")
    vehicle_ardupilot.arm()
    assert vehicle_ardupilot.step(0.5, vehicle_ardupilot.hold).task is Task.IDLE, "a setpoint lifts nothing"
    assert brain.request_take_off(0.0) == FAILED and brain.request_take_off(1.0) == 0
    assert vehicle_ardupilot.step(0.1).position[2] == 1.0
    vehicle_ardupilot.position[2] = 0.3
    vehicle_ardupilot.step(0.1)
    assert brain.request_take_off(1.0) == FAILED, "it flies already"
    vehicle_ardupilot.hold()
    assert vehicle_ardupilot.step(0.0).position[2] == pytest.approx(0.8), "a setpoint ends the take-off"


@pytest.mark.parametrize(
    ("quaternion", "mask"), [(LEVEL, 7 | 64), (LEVEL, 7 | 128), (LEVEL, 0), (1.01 * LEVEL, 7), (math.nan * LEVEL, 7)]
)
def test_a_target_that_is_ill_defined_is_none_for_px4_and_stops_ardupilot(vehicle, quaternion, mask):
    vehicle.fly()
    vehicle.tilt(0.6, quaternion, mask)
    px4 = vehicle.brain.dialect.heeds_stream
    assert vehicle.step(0.0).task is (Task.POSITION if px4 else Task.VELOCITY)
    vehicle.go(0, frame=mavlink.MAV_FRAME_BODY_NED)
    vehicle.go(0, velocity=np.array([math.nan, 0.0, 0.0]))
    assert vehicle.step(0.0).task is (Task.POSITION if px4 else Task.VELOCITY)


def test_a_target_that_is_well_defined_is_obeyed(vehicle):
    vehicle.fly()
    vehicle.tilt(0.6, TILTED)
    demand = vehicle.step(0.0)
    boost = 1.0 if vehicle.brain.dialect.heeds_stream else 1.0 / math.cos(0.4)
    assert demand.task is Task.ATTITUDE and demand.thrust == pytest.approx(0.6 * boost)
    vehicle.go(0, 1.0 + NO, 2.0 + NO, 3.0 + NO, 0.5)
    demand = vehicle.step(0.0)
    assert [demand.position[0], demand.velocity[0], demand.acceleration[0], demand.yaw] == [1.0, 2.0, 3.0, 0.5]


def test_ardupilot_whose_thrust_is_a_climb_rate_is_not_flown_by_thrust(vehicle_ardupilot):
    vehicle_ardupilot.parameters["GUID_OPTIONS"] = 0
    vehicle_ardupilot.fly()
    vehicle_ardupilot.tilt(0.6)
    assert vehicle_ardupilot.step(0.0).task is Task.VELOCITY


def test_ardupilot_forgets_an_attitude_but_never_a_position(vehicle_ardupilot):
    vehicle_ardupilot.fly()
    vehicle_ardupilot.tilt(0.6, TILTED)
    assert vehicle_ardupilot.step(2.9).task is Task.ATTITUDE, "GUID_TIMEOUT is three seconds"
    assert vehicle_ardupilot.step(0.3).task is Task.VELOCITY
    vehicle_ardupilot.hold()
    assert vehicle_ardupilot.step(60.0).task is Task.POSITION


# ------------------------------------------------------------ failsafes


@pytest.mark.parametrize("chosen", [None, "position"])
def test_px4_goes_back_to_offboard_when_its_stream_does_unless_somebody_chose_another_mode(vehicle_px4, chosen):
    vehicle_px4.parameters["COM_OBL_RC_ACT"] = 4
    vehicle_px4.fly()
    vehicle_px4.step(2.0)
    assert vehicle_px4.brain.is_in("land")
    if chosen is not None:
        vehicle_px4.brain.pilot_mode(chosen)
    vehicle_px4.step(0.5, vehicle_px4.hold)
    assert vehicle_px4.brain.is_in(chosen or "companion")


@pytest.mark.parametrize(("action", "mode"), [(2, "return"), (3, "land")])
def test_px4_acts_on_the_loss_of_the_station(vehicle_px4, action, mode):
    vehicle_px4.parameters["NAV_DLL_ACT"] = action
    vehicle_px4.fly()
    vehicle_px4.station_age = 11.0
    vehicle_px4.step(0.2, vehicle_px4.hold)
    assert vehicle_px4.brain.is_in(mode)


@pytest.mark.parametrize(("height", "most"), [(0.0, 1.2), (3.0, 3.0)])
def test_a_return_climbs_as_its_parameter_says_and_lands_at_home(vehicle, height, most):
    name, unit = vehicle.brain.dialect.return_height
    vehicle.parameters[name] = height / unit
    vehicle.fly()
    vehicle.position = np.array([1.2, -0.9, 1.2])
    vehicle.brain.pilot_mode("return")
    places = []
    for _ in range(1000):
        demand = vehicle.step(0.02)
        if demand.task is Task.LAND:
            break
        vehicle.position = demand.position.copy()
        places.append(vehicle.position)
    path = np.array(places)
    assert demand.task is Task.LAND and np.linalg.norm(path[-1, :2]) < 0.2
    assert path[:, 2].max() == pytest.approx(most) and np.abs(np.diff(path[:, :2], axis=0)).max() < 0.04, "no jump"


def test_without_a_place_on_earth_px4_lands_instead_of_returning(vehicle_px4):
    vehicle_px4.on_earth = False
    vehicle_px4.fly()
    vehicle_px4.brain.pilot_mode("loiter")
    assert vehicle_px4.brain.is_in("companion"), "not available"
    assert vehicle_px4.step(3.0).task is Task.LAND


# ------------------------------------------------------------ landing


def test_a_landing_that_something_stops_is_over(vehicle):
    vehicle.fly()
    vehicle.brain.request_land()
    vehicle.step(0.8)
    assert not vehicle.brain.landed, "it has not begun to sink"
    vehicle.velocity[2] = -0.6
    vehicle.step(3.0)
    assert vehicle.brain.armed and not vehicle.brain.landed
    vehicle.velocity[2] = -0.02
    vehicle.step(4.0)
    assert not vehicle.brain.armed


def standing(time: float) -> PlantTruth:
    return PlantTruth(np.array([0.1 * time, 0.0, 1.0]), np.array([0.1, 0.0, 0.0]), LEVEL, NO, False)


def test_an_estimate_by_poses_is_valid_after_some_and_drifts_away_without():
    estimator = Estimator(0.0, standing(0.0), 5.0, False, vision=True)
    now, estimate = 0.0, None
    for k in range(1000):
        now = 0.01 * k
        estimate = estimator.update(now, standing(now), 0.01)
        if k % 2 == 0 and now < 4.0:
            assert estimate.position_valid == (estimator.accepted_poses >= 10)
            estimator.pose(now, now - 0.03, standing(now - 0.03).position)
        if now == 3.9:
            assert np.linalg.norm(estimate.position - standing(now).position) < 1e-3
    assert not estimate.position_valid, "5 s after the last pose"
    drift = float(np.linalg.norm(estimate.position - standing(now).position))
    assert 0.2 < drift < 2.0


def test_poses_with_wrong_stamps_or_places_do_not_count_at_once():
    estimator = Estimator(0.0, standing(0.0), 5.0, False, vision=True)
    for k in range(100):
        now = 0.01 * k
        estimator.update(now, standing(now), 0.01)
        estimator.pose(now, now, standing(now).position)
    accepted = estimator.accepted_poses
    estimator.pose(now, now - 50.0, standing(now).position)
    estimator.pose(now, now + 5.0, standing(now).position)
    estimator.pose(now, now, standing(now).position + 3.0)
    assert estimator.accepted_poses == accepted
