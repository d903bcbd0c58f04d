"""Rules of the emulated autopilot, with time made up: modes, arming, streams and failsafes of PX4 and ArduPilot."""

from __future__ import annotations

import math

import numpy as np
import pytest
from autopilot_sandbox import LEVEL, NED, Sandbox, offboard
from pixhawk_rig import NO
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot import px4
from doorman.rig.emulators.autopilot.ardupilot import GUIDED, LAND
from doorman.rig.emulators.autopilot.brain import PositionTarget
from doorman.rig.emulators.autopilot.control import Task


def test_px4_acknowledges_offboard_without_a_stream_and_does_not_change(vehicle_px4):
    for stream in (None, vehicle_px4.hold):
        before = vehicle_px4.brain.mode
        assert vehicle_px4.brain.request_mode((1.0, 6.0, 0.0)) == 0
        assert vehicle_px4.brain.mode == before
        vehicle_px4.step(0.1, stream)
    offboard(vehicle_px4)


@pytest.mark.parametrize(("limit", "waited", "entered"), [(1.0, 0.8, True), (1.0, 1.2, False), (0.2, 0.4, False)])
def test_px4_takes_one_setpoint_for_a_stream_as_long_as_it_is_new(vehicle_px4, limit, waited, entered):
    vehicle_px4.brain.parameters["COM_OF_LOSS_T"] = limit
    vehicle_px4.hold()
    vehicle_px4.step(waited)
    vehicle_px4.brain.request_mode((1.0, 6.0, 0.0))
    assert (vehicle_px4.brain.mode == px4.OFFBOARD) is entered


def test_px4_drops_other_frames_and_says_so(vehicle_px4):
    target = PositionTarget(2552, mavlink.MAV_FRAME_LOCAL_FRD, NO, NO, NO, 0.0)
    vehicle_px4.step(1.0, lambda: vehicle_px4.brain.position_target(target))
    assert [text for _, text in vehicle_px4.brain.texts] == ["SET_POSITION_TARGET coordinate frame 20 unsupported"]
    vehicle_px4.brain.request_mode((1.0, 6.0, 0.0))
    assert vehicle_px4.brain.mode != px4.OFFBOARD


def test_px4_flies_velocities_along_its_heading(vehicle_px4):
    vehicle_px4.attitude = np.array([math.cos(0.25 * math.pi), 0.0, 0.0, math.sin(0.25 * math.pi)])
    body = PositionTarget(2503, mavlink.MAV_FRAME_BODY_NED, NO, np.array([1.0, 0.0, 0.5]), NO, 0.0)
    offboard(vehicle_px4)
    vehicle_px4.brain.request_arming(True, False)
    demand = vehicle_px4.step(0.2, lambda: vehicle_px4.brain.position_target(body))
    assert demand.task is Task.VELOCITY
    assert demand.velocity == pytest.approx([0.0, 1.0, 0.5], abs=1e-9)


def test_px4_in_the_air_refuses_a_mode_that_it_cannot_fly(vehicle_px4):
    vehicle_px4.brain.request_arming(True, False)
    vehicle_px4.position[2] = 1.0
    vehicle_px4.step(0.1)
    assert vehicle_px4.brain.request_mode((1.0, 6.0, 0.0)) == 1, "no stream"
    vehicle_px4.on_earth = False
    vehicle_px4.step(0.1)
    assert vehicle_px4.brain.request_return() == 1, "no home"
    assert vehicle_px4.brain.mode == px4.LOITER
    vehicle_px4.valid = False
    vehicle_px4.step(0.02)
    assert vehicle_px4.brain.request_take_off(2.0) == 1
    assert vehicle_px4.brain.request_mode((1.0, 4.0, 6.0)) == 0, "a landing is never refused"


def test_px4_takes_off_and_holds_where_it_arrived(vehicle_px4):
    brain = vehicle_px4.brain
    vehicle_px4.position[2] = 0.005
    brain.request_arming(True, False)
    vehicle_px4.step(0.1)
    for ask in (lambda: brain.request_take_off(math.nan), lambda: brain.request_mode((1.0, 4.0, 2.0))):
        assert ask() == 0
        demand = vehicle_px4.step(0.1)
        assert demand.position[2] == pytest.approx(2.505) and brain.taking_off
    vehicle_px4.position[2] = 1.5
    vehicle_px4.step(0.1)
    assert brain.mode == px4.TAKE_OFF, "not there"
    vehicle_px4.position[2] = 1.8
    assert vehicle_px4.step(0.1).position[2] == pytest.approx(2.505)
    assert brain.mode == px4.LOITER and not brain.taking_off
    assert brain.request_take_off(0.5) == 0
    assert vehicle_px4.step(0.1).position[2] == pytest.approx(1.8), "it does not go down"
    assert "higher" in brain.texts[-1][1]


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_px4_leaves_out_what_is_no_number(vehicle_px4, bad):
    offboard(vehicle_px4)
    vehicle_px4.brain.request_arming(True, False)
    push = np.array([bad, 0.0, 0.0])
    target = PositionTarget(2048, NED, np.array([0.0, 0.0, 1.0]), NO, push, bad)
    demand = vehicle_px4.step(0.2, lambda: vehicle_px4.brain.position_target(target))
    assert demand.task is Task.POSITION and demand.yaw is None and not demand.acceleration.any()
    vehicle_px4.tilt(0.6, 0.0 * LEVEL)
    assert vehicle_px4.step(0.0).task is Task.POSITION, "no attitude at all"


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


@pytest.mark.parametrize("barometer", [0, 1])
def test_px4_without_poses_notices_that_it_has_landed_by_its_barometer_only(vehicle_px4, barometer):
    vehicle_px4.brain.parameters["EKF2_BARO_CTRL"] = barometer
    offboard(vehicle_px4)
    vehicle_px4.brain.request_arming(True, False)
    vehicle_px4.position[2] = 1.0
    vehicle_px4.step(0.5, vehicle_px4.hold)
    vehicle_px4.valid = False
    vehicle_px4.step(1.0, vehicle_px4.hold)
    assert vehicle_px4.brain.mode == px4.LAND and not vehicle_px4.brain.landed
    vehicle_px4.position[2] = 0.0
    vehicle_px4.step(20.0)
    assert (vehicle_px4.brain.landed, vehicle_px4.brain.armed) == ((True, False) if barometer else (False, True))


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


def test_ardupilot_that_is_told_to_brake_only_hovers(vehicle_ardupilot):
    airborne(vehicle_ardupilot)
    vehicle_ardupilot.brain.parameters["FS_GCS_ENABLE"] = 7
    vehicle_ardupilot.station_age = 6.0
    assert vehicle_ardupilot.step(60.0).task is Task.POSITION


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


def test_ardupilot_ends_its_take_off_where_it_wanted_to(vehicle_ardupilot):
    guided(vehicle_ardupilot)
    vehicle_ardupilot.brain.request_take_off(1.0)
    vehicle_ardupilot.step(0.1)
    vehicle_ardupilot.position[2], vehicle_ardupilot.velocity[2] = 0.97, 1.0
    vehicle_ardupilot.step(0.1)
    assert vehicle_ardupilot.brain.taking_off, "it still climbs"
    vehicle_ardupilot.velocity[2] = 0.1
    vehicle_ardupilot.step(0.1)
    assert not vehicle_ardupilot.brain.taking_off
    assert vehicle_ardupilot.step(60.0).position[2] == 1.0, "and stays there"


def test_ardupilot_that_must_arm_still_needs_a_position_where_the_mode_does(vehicle_ardupilot):
    vehicle_ardupilot.now = 1.0
    vehicle_ardupilot.brain.request_mode((1.0, 4.0, 0.0))
    vehicle_ardupilot.valid = False
    vehicle_ardupilot.step(0.1)
    assert vehicle_ardupilot.brain.request_arming(True, True) == 4
    vehicle_ardupilot.valid = True
    vehicle_ardupilot.step(0.1)
    assert vehicle_ardupilot.brain.request_arming(True, False) == 4, "its gyros"
    assert vehicle_ardupilot.brain.request_arming(True, True) == 0


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_ardupilot_stops_at_what_is_no_number(vehicle_ardupilot, bad):
    airborne(vehicle_ardupilot)
    vehicle_ardupilot.tilt(bad)
    assert vehicle_ardupilot.step(0.0).task is Task.VELOCITY
    push = np.array([bad, 0.0, 0.0])
    vehicle_ardupilot.brain.position_target(PositionTarget(2048, NED, NO, np.ones(3), push, 0.0))
    assert not vehicle_ardupilot.step(0.0).velocity.any()
    vehicle_ardupilot.brain.position_target(PositionTarget(2552, NED, NO, NO, NO, bad))
    assert vehicle_ardupilot.step(0.0).yaw is None


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
