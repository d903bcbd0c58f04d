"""Rules of the emulated autopilot, with time made up: modes, arming, streams and failsafes of PX4 and ArduPilot."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from autopilot_sandbox import LEVEL, NED, Sandbox
from pixhawk_rig import NO
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.hardware.emulators import autopilot_px4 as px4
from doorman.hardware.emulators.autopilot_ardupilot import GUIDED, LAND, ArduPilotBrain
from doorman.hardware.emulators.autopilot_brain import PositionTarget
from doorman.hardware.emulators.autopilot_control import Task
from doorman.hardware.emulators.autopilot_parameters import ARDUPILOT_DEFAULTS, PX4_DEFAULTS, ParameterStore


def offboard(sandbox: Sandbox) -> None:
    sandbox.step(0.6, sandbox.hold)
    assert sandbox.brain.request_mode((1.0, 6.0, 0.0)) == 0
    assert sandbox.brain.mode == px4.OFFBOARD


@pytest.fixture
def vehicle_px4() -> Sandbox:
    return Sandbox(px4.Px4Brain(ParameterStore(PX4_DEFAULTS, bytewise=True)))


@pytest.fixture
def vehicle_ardupilot() -> Sandbox:
    return Sandbox(ArduPilotBrain(ParameterStore(ARDUPILOT_DEFAULTS, bytewise=False), start_up=22.0))


def test_px4_acknowledges_offboard_without_a_stream_and_does_not_change(vehicle_px4):
    for stream in (None, vehicle_px4.hold):
        before = vehicle_px4.brain.mode
        assert vehicle_px4.brain.request_mode((1.0, 6.0, 0.0)) == 0
        assert vehicle_px4.brain.mode == before
        vehicle_px4.step(0.1, stream)
    offboard(vehicle_px4)


def test_px4_calls_less_than_two_setpoints_a_second_no_stream(vehicle_px4):
    for _ in range(6):
        vehicle_px4.hold()
        vehicle_px4.step(0.6)
    vehicle_px4.brain.request_mode((1.0, 6.0, 0.0))
    assert vehicle_px4.brain.mode != px4.OFFBOARD


def test_px4_drops_other_frames_silently(vehicle_px4):
    target = PositionTarget(2552, mavlink.MAV_FRAME_LOCAL_FRD, NO, NO, NO, 0.0)
    vehicle_px4.step(1.0, lambda: vehicle_px4.brain.position_target(target))
    vehicle_px4.brain.request_mode((1.0, 6.0, 0.0))
    assert vehicle_px4.brain.mode != px4.OFFBOARD


@pytest.mark.parametrize(("action", "mode"), [(4, px4.LAND), (0, px4.RETURN), (5, px4.LOITER)])
def test_px4_without_its_stream_does_what_its_parameter_says(vehicle_px4, action, mode):
    vehicle_px4.brain.parameters["COM_OBL_RC_ACT"] = action
    offboard(vehicle_px4)
    assert vehicle_px4.brain.request_arming(True, False) == 0
    vehicle_px4.step(0.5, vehicle_px4.hold)
    vehicle_px4.position[2] = 1.0
    vehicle_px4.step(0.9)
    assert vehicle_px4.brain.mode == px4.OFFBOARD, "COM_OF_LOSS_T is one second"
    vehicle_px4.step(0.8)
    assert vehicle_px4.brain.mode == mode and vehicle_px4.brain.failsafe
    assert any("offboard" in text for _, text in vehicle_px4.brain.texts)


def test_px4_goes_back_to_offboard_when_its_stream_does_unless_somebody_chose_another_mode(vehicle_px4):
    vehicle_px4.brain.parameters["COM_OBL_RC_ACT"] = 4
    offboard(vehicle_px4)
    vehicle_px4.brain.request_arming(True, False)
    vehicle_px4.step(0.5, vehicle_px4.hold)
    vehicle_px4.position[2] = 1.0
    for chosen in (None, "position"):
        vehicle_px4.step(2.0)
        assert vehicle_px4.brain.mode == px4.LAND and vehicle_px4.brain.failsafe
        if chosen is not None:
            vehicle_px4.brain.pilot_mode(chosen)
        vehicle_px4.step(0.5, vehicle_px4.hold)
        assert vehicle_px4.brain.mode == (px4.OFFBOARD if chosen is None else px4.POSITION)


def test_px4_lands_from_offboard_when_its_position_is_gone(vehicle_px4):
    offboard(vehicle_px4)
    vehicle_px4.brain.request_arming(True, False)
    vehicle_px4.valid = False
    vehicle_px4.step(2.0, vehicle_px4.hold)
    assert vehicle_px4.brain.mode == px4.LAND


def test_px4_flies_attitude_without_a_position(vehicle_px4):
    vehicle_px4.valid = False
    vehicle_px4.step(1.0, vehicle_px4.tilt)
    vehicle_px4.brain.request_mode((1.0, 6.0, 0.0))
    assert vehicle_px4.brain.mode == px4.OFFBOARD


def test_px4_does_not_arm_without_stream_position_or_station(vehicle_px4):
    offboard(vehicle_px4)
    vehicle_px4.step(1.5)
    assert vehicle_px4.brain.request_arming(True, False) == 1
    vehicle_px4.step(0.6, vehicle_px4.hold)
    vehicle_px4.valid = False
    vehicle_px4.step(0.1, vehicle_px4.hold)
    vehicle_px4.brain.texts.clear()
    assert vehicle_px4.brain.request_arming(True, False) == 1
    vehicle_px4.valid = True
    vehicle_px4.brain.parameters["NAV_DLL_ACT"] = 2
    vehicle_px4.station_age = math.inf
    vehicle_px4.step(0.1, vehicle_px4.hold)
    assert vehicle_px4.brain.request_arming(True, False) == 1
    assert "GCS" in vehicle_px4.brain.texts[-1][1]
    vehicle_px4.station_age = 0.5
    vehicle_px4.step(0.1, vehicle_px4.hold)
    assert vehicle_px4.brain.request_arming(True, False) == 0


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


def test_ardupilot_that_is_told_to_brake_only_hovers(vehicle_ardupilot):
    airborne(vehicle_ardupilot)
    vehicle_ardupilot.brain.parameters["FS_GCS_ENABLE"] = 7
    vehicle_ardupilot.station_age = 6.0
    assert vehicle_ardupilot.step(60.0).task is Task.POSITION


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


@pytest.mark.parametrize(("action", "mode"), [(2, px4.RETURN), (3, px4.LAND)])
def test_px4_acts_on_the_loss_of_the_station(vehicle_px4, action, mode):
    vehicle_px4.brain.parameters["NAV_DLL_ACT"] = action
    offboard(vehicle_px4)
    vehicle_px4.brain.request_arming(True, False)
    vehicle_px4.station_age = 11.0
    vehicle_px4.step(0.2, vehicle_px4.hold)
    assert vehicle_px4.brain.mode == mode


def test_px4_disarms_if_it_does_not_take_off(vehicle_px4):
    vehicle_px4.brain.request_arming(True, False)
    vehicle_px4.step(9.0)
    assert vehicle_px4.brain.armed
    vehicle_px4.step(2.0)
    assert not vehicle_px4.brain.armed


def test_the_pilot_always_wins(vehicle_px4, vehicle_ardupilot):
    offboard(vehicle_px4)
    vehicle_px4.brain.pilot_mode("position")
    vehicle_px4.step(1.0, vehicle_px4.hold)
    assert vehicle_px4.brain.mode == px4.POSITION
    vehicle_ardupilot.brain.request_mode((1.0, 4.0, 0.0))
    vehicle_ardupilot.brain.pilot_mode("loiter")
    assert vehicle_ardupilot.brain.mode == 5
    for sandbox in (vehicle_px4, vehicle_ardupilot):
        with pytest.raises(ValueError, match="unknown mode"):
            sandbox.brain.pilot_mode("warp")


def guided(sandbox: Sandbox) -> None:
    assert sandbox.brain.request_mode((1.0, 4.0, 0.0)) == 0
    assert sandbox.brain.request_arming(True, False) == 0
    sandbox.step(0.1)


def test_ardupilot_waits_for_its_gyros(vehicle_ardupilot):
    vehicle_ardupilot.now = 21.0
    vehicle_ardupilot.brain.request_mode((1.0, 4.0, 0.0))
    vehicle_ardupilot.step(0.1)
    assert vehicle_ardupilot.brain.request_arming(True, False) == 4
    assert "yros" in vehicle_ardupilot.brain.texts[-1][1]
    vehicle_ardupilot.step(1.0)
    assert vehicle_ardupilot.brain.request_arming(True, False) == 0


def test_ardupilot_needs_a_position_for_guided(vehicle_ardupilot):
    vehicle_ardupilot.valid = False
    vehicle_ardupilot.step(0.1)
    assert vehicle_ardupilot.brain.request_mode((1.0, 4.0, 0.0)) == 4
    assert vehicle_ardupilot.brain.mode == 0


def test_ardupilot_takes_off_by_command_only(vehicle_ardupilot):
    brain = vehicle_ardupilot.brain
    vehicle_ardupilot.hold()
    assert brain.request_take_off(1.0) == 4, "disarmed"
    guided(vehicle_ardupilot)
    assert vehicle_ardupilot.step(0.5, vehicle_ardupilot.hold).task is Task.IDLE, "a setpoint lifts nothing"
    assert brain.request_take_off(0.0) == 4
    assert brain.request_take_off(1.0) == 0
    demand = vehicle_ardupilot.step(0.1)
    assert demand.task is Task.POSITION and demand.position[2] == 1.0
    vehicle_ardupilot.position[2] = 0.3
    vehicle_ardupilot.step(0.1)
    assert brain.request_take_off(1.0) == 4, "it flies already"
    vehicle_ardupilot.hold()
    assert vehicle_ardupilot.step(0.0).position[2] == pytest.approx(0.8), "a setpoint ends the take-off"


def airborne(sandbox: Sandbox) -> None:
    guided(sandbox)
    sandbox.brain.request_take_off(1.0)
    sandbox.step(0.1)
    sandbox.position[2] = 1.0
    sandbox.step(0.1)


def test_ardupilot_ignores_setpoints_while_disarmed(vehicle_ardupilot):
    vehicle_ardupilot.brain.request_mode((1.0, 4.0, 0.0))
    vehicle_ardupilot.hold()
    airborne(vehicle_ardupilot)
    assert vehicle_ardupilot.step(0.1).position[2] == 1.0


def test_ardupilot_takes_thrust_for_a_climb_rate_unless_told_otherwise(vehicle_ardupilot):
    airborne(vehicle_ardupilot)
    vehicle_ardupilot.tilt(0.5)
    demand = vehicle_ardupilot.step(0.0)
    assert demand.task is Task.CLIMB_RATE and demand.climb_rate == 0.0
    vehicle_ardupilot.tilt(0.75)
    assert vehicle_ardupilot.step(0.0).climb_rate > 1.0
    vehicle_ardupilot.brain.parameters["GUID_OPTIONS"] = 8
    vehicle_ardupilot.tilt(0.6)
    demand = vehicle_ardupilot.step(0.0)
    assert demand.task is Task.ATTITUDE and demand.thrust == pytest.approx(0.6)


def test_ardupilot_divides_thrust_by_the_tilt(vehicle_ardupilot):
    vehicle_ardupilot.brain.parameters["GUID_OPTIONS"] = 8
    airborne(vehicle_ardupilot)
    tilted_by = np.array([math.cos(0.2), math.sin(0.2), 0.0, 0.0])
    vehicle_ardupilot.tilt(0.4, tilted_by)
    assert vehicle_ardupilot.step(0.0).thrust == pytest.approx(0.4 / math.cos(0.4))
    vehicle_ardupilot.brain.parameters["ATC_ANGLE_BOOST"] = 0
    vehicle_ardupilot.tilt(0.4, tilted_by)
    assert vehicle_ardupilot.step(0.0).thrust == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("quaternion", "mask"), [(1.01 * LEVEL, 7), (LEVEL, 0), (LEVEL, 7 | 64), (math.nan * LEVEL, 7)]
)
def test_ardupilot_stops_at_a_target_that_is_ill_defined(vehicle_ardupilot, quaternion, mask):
    vehicle_ardupilot.brain.parameters["GUID_OPTIONS"] = 8
    airborne(vehicle_ardupilot)
    vehicle_ardupilot.tilt(0.6, quaternion, mask)
    assert vehicle_ardupilot.step(0.0).task is Task.VELOCITY


def test_ardupilot_forgets_attitude_and_velocity_but_never_a_position(vehicle_ardupilot):
    brain = vehicle_ardupilot.brain
    brain.parameters["GUID_OPTIONS"] = 8
    airborne(vehicle_ardupilot)
    vehicle_ardupilot.tilt(0.6, np.array([math.cos(0.2), math.sin(0.2), 0.0, 0.0]))
    assert vehicle_ardupilot.step(2.9).task is Task.ATTITUDE, "GUID_TIMEOUT is three seconds"
    demand = vehicle_ardupilot.step(0.3)
    assert demand.task is Task.CLIMB_RATE and np.allclose(demand.quaternion, LEVEL)
    brain.position_target(PositionTarget(2503, NED, NO, np.array([0.5, 0.0, 0.0]), NO, 0.0))
    assert vehicle_ardupilot.step(0.1).velocity[0] == 0.5
    assert vehicle_ardupilot.step(3.2).velocity[0] == 0.0
    vehicle_ardupilot.hold()
    assert vehicle_ardupilot.step(60.0).task is Task.POSITION


def test_ardupilot_lands_without_station_or_estimate(vehicle_ardupilot):
    airborne(vehicle_ardupilot)
    vehicle_ardupilot.station_age = 6.0
    vehicle_ardupilot.step(0.1)
    assert vehicle_ardupilot.brain.mode == GUIDED, "FS_GCS_ENABLE is 0 by default"
    vehicle_ardupilot.brain.parameters["FS_GCS_ENABLE"] = 5
    vehicle_ardupilot.step(0.1)
    assert vehicle_ardupilot.brain.mode == LAND and vehicle_ardupilot.brain.failsafe


@pytest.mark.parametrize("fixture", ["vehicle_px4", "vehicle_ardupilot"])
def test_a_landing_ends_disarmed_on_the_ground(request, fixture):
    sandbox = request.getfixturevalue(fixture)
    sandbox.brain.request_arming(True, False)
    sandbox.brain.landed = False
    sandbox.position[2], sandbox.velocity[2] = 1.0, -0.6
    sandbox.brain.request_land()
    assert sandbox.step(5.0).task is Task.LAND and sandbox.brain.armed
    assert sandbox.brain.request_arming(False, False) == sandbox.brain.refused_result, "not in the air"
    sandbox.position[2], sandbox.velocity[2] = 0.0, 0.0
    sandbox.step(3.0)
    assert not sandbox.brain.armed


@pytest.mark.parametrize("fixture", ["vehicle_px4", "vehicle_ardupilot"])
def test_a_landing_that_something_stops_is_over(request, fixture):
    sandbox = request.getfixturevalue(fixture)
    sandbox.brain.request_arming(True, False)
    sandbox.brain.landed = False
    sandbox.position[2], sandbox.velocity[2] = 1.0, 0.0
    sandbox.brain.request_land()
    sandbox.step(0.8)
    assert sandbox.brain.armed and not sandbox.brain.landed, "it has not begun to sink"
    sandbox.velocity[2] = -0.6
    sandbox.step(3.0)
    assert sandbox.brain.armed and not sandbox.brain.landed
    sandbox.velocity[2] = -0.02
    sandbox.step(4.0)
    assert not sandbox.brain.armed
