"""What clients other than doorman's adapter ask of the emulated autopilot, as they ask it of the real ones."""

from __future__ import annotations

import logging
import math

import numpy as np
import pytest
from pixhawk_rig import wait_until
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot import px4
from doorman.rig.emulators.autopilot.ardupilot import GUIDED, RETURN
from doorman.rig.emulators.autopilot.earth import ZURICH, global_position

NAN = math.nan
INTERVAL, REQUEST = mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, mavlink.MAV_CMD_REQUEST_MESSAGE


def alive(client) -> bool:
    client.seen.clear()
    client.send(mavlink.MAVLink_timesync_message(0, 4711))
    return client.get("TIMESYNC", lambda message: message.ts1 == 4711) is not None


def ready(client):
    assert wait_until(lambda: client.emulator.estimate.position_valid and client.emulator.brain.around is not None)
    return client


# ------------------------------------------------------------ figures


@pytest.mark.parametrize("bad", [NAN, math.inf])
def test_parameters_of_commands_that_are_no_numbers_are_denied(clients, flavour, bad):
    client = ready(clients(flavour))
    for number, values in (
        (mavlink.MAV_CMD_DO_SET_MODE, (1.0, bad, 0.0)),
        (INTERVAL, (30.0, bad)),
        (REQUEST, (bad,)),
        (mavlink.MAV_CMD_COMPONENT_ARM_DISARM, (bad,)),
        (mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, (bad,)),
    ):
        assert client.command(number, *values) == mavlink.MAV_RESULT_DENIED, number
    assert alive(client)


def test_what_is_not_read_need_not_be_a_number(clients):
    client = ready(clients("px4"))
    assert client.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0, *[NAN] * 6) == 0, "as MAVSDK arms"


def test_ardupilot_takes_no_parameter_that_is_no_number(clients):
    client = clients("ardupilot")
    for name, bad in (("RTL_ALT", NAN), ("GUID_TIMEOUT", math.inf)):
        client.send(mavlink.MAVLink_param_set_message(1, 1, name.encode(), bad, 9))
    assert alive(client)
    assert client.emulator.parameters.writes == 0


def test_what_a_message_raises_is_told_once_and_does_not_end_it(clients, caplog):
    client = clients("px4")

    def stumble(message):
        raise ZeroDivisionError

    client.emulator.protocol._handlers["HEARTBEAT"] = stumble
    with caplog.at_level(logging.ERROR):
        for _ in range(3):
            client.send(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
        assert alive(client)
    assert [record.message for record in caplog.records if "HEARTBEAT" in record.message] == [
        "the emulated autopilot goes on without this HEARTBEAT"
    ]


# ------------------------------------------------------------ modes


def test_the_older_set_mode_changes_it_and_only_px4_acknowledges(clients):
    client = ready(clients("px4"))
    client.send(mavlink.MAVLink_set_mode_message(1, 1, px4.POSITION))
    client.get("HEARTBEAT", lambda message: message.custom_mode == px4.POSITION)
    client.send(mavlink.MAVLink_set_mode_message(1, 1, px4.LOITER))
    client.get("HEARTBEAT", lambda message: message.custom_mode == px4.LOITER)
    assert client.get("COMMAND_ACK").command == mavlink.MAV_CMD_DO_SET_MODE
    client = ready(clients("ardupilot"))
    client.send(mavlink.MAVLink_set_mode_message(1, 1, GUIDED))
    client.get("HEARTBEAT", lambda message: message.custom_mode == GUIDED)
    assert not [message for message in client.seen if message.get_type() == "COMMAND_ACK"]


def test_both_return_by_command(clients):
    for flavour, mode in (("px4", px4.RETURN), ("ardupilot", RETURN)):
        client = ready(clients(flavour))
        assert client.command(mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH) == 0
        assert client.emulator.brain.mode == mode


# ------------------------------------------------------------ telemetry


def test_attitude_comes_in_angles_too(clients):
    client = ready(clients("px4"))
    client.emulator.plant._quaternion = np.array([math.cos(0.2), 0.0, 0.0, math.sin(0.2)])
    assert client.command(INTERVAL, 30.0, 10_000.0) == 0
    assert client.get("ATTITUDE", lambda message: abs(message.yaw + 0.4) < 1e-3).roll == pytest.approx(0.0, abs=1e-6)


def test_ardupilots_streams(clients):
    client = ready(clients("ardupilot"))
    client.send(mavlink.MAVLink_request_data_stream_message(1, 1, mavlink.MAV_DATA_STREAM_EXTRA1, 20, 1))
    client.get("ATTITUDE")
    assert not [message for message in client.seen if message.get_type() == "LOCAL_POSITION_NED"]
    client.send(mavlink.MAVLink_request_data_stream_message(1, 1, mavlink.MAV_DATA_STREAM_ALL, 20, 1))
    for kind in ("LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "SYS_STATUS", "GPS_RAW_INT", "BATTERY_STATUS"):
        client.get(kind)
    client.send(mavlink.MAVLink_request_data_stream_message(1, 1, mavlink.MAV_DATA_STREAM_ALL, 20, 0))
    assert alive(client)
    client.seen.clear()
    client.get("HEARTBEAT")
    assert {message.get_type() for message in client.seen} <= {"HEARTBEAT", "TIMESYNC"}


@pytest.mark.parametrize(("flavour", "refused"), [("px4", 2), ("ardupilot", 4)])
def test_messages_are_told_on_request(clients, flavour, refused):
    client = ready(clients(flavour))
    for identifier, kind in ((30, "ATTITUDE"), (49, "GPS_GLOBAL_ORIGIN"), (242, "HOME_POSITION")):
        assert client.command(REQUEST, float(identifier)) == 0
        client.get(kind)
    assert client.command(REQUEST, 148.0) == 0
    version = client.get("AUTOPILOT_VERSION")
    assert version.flight_sw_version >> 24 == (1 if flavour == "px4" else 4)
    assert version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    bytewise = version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
    assert bool(bytewise) == (flavour == "px4")
    assert client.command(REQUEST, 230.0 if flavour == "ardupilot" else 65.0) == refused


def test_there_are_no_missions(clients, flavour):
    client = clients(flavour)
    client.send(mavlink.MAVLink_mission_request_list_message(1, 1, mavlink.MAV_MISSION_TYPE_FENCE))
    answer = client.get("MISSION_COUNT")
    assert (answer.count, answer.mission_type) == (0, mavlink.MAV_MISSION_TYPE_FENCE)
    assert (answer.target_system, answer.target_component) == (255, 190)


def test_a_place_on_earth_is_told_where_there_is_one(clients):
    client = ready(clients("px4"))
    place = client.get("GLOBAL_POSITION_INT")
    assert (place.lat, place.lon) == pytest.approx((473977420, 85455940), abs=200)
    assert place.alt == pytest.approx(488_000, abs=50) and place.relative_alt == pytest.approx(0, abs=50)
    assert client.get("HOME_POSITION").altitude == pytest.approx(488_000, abs=50)
    assert client.get("GPS_RAW_INT").fix_type == mavlink.GPS_FIX_TYPE_3D_FIX
    client = clients("px4", vision=True)
    assert client.command(REQUEST, 33.0) == mavlink.MAV_RESULT_DENIED
    client.send(mavlink.MAVLink_set_gps_global_origin_message(1, 473977420, 85455940, 0))
    client.get("GPS_GLOBAL_ORIGIN")
    for step in range(12):
        client.send(mavlink.MAVLink_vision_position_estimate_message(1_000_000 + step, 10.0, 20.0, -1.0, 0, 0, 0))
        assert alive(client)
    client.get("GLOBAL_POSITION_INT")
    assert client.command(REQUEST, 24.0) == mavlink.MAV_RESULT_DENIED, "it has no receiver"


def test_east_and_north_of_the_origin():
    there = global_position(0, ZURICH, np.array([100.0, -50.0, 7.0]), np.array([1.0, -2.0, 3.0]), 0.5, np.zeros(3))
    assert there.lat * 1e-7 - ZURICH.latitude == pytest.approx(100.0 / 111_194.9, rel=1e-3)
    assert there.lon * 1e-7 - ZURICH.longitude == pytest.approx(50.0 / (111_194.9 * 0.67690), rel=1e-3)
    assert (there.alt, there.relative_alt) == (495_000, 7_000)
    assert (there.vx, there.vy, there.vz) == (100, 200, -300)
    assert there.hdg == round(36000 - math.degrees(0.5) * 100)


# ------------------------------------------------------------ commands


def test_commands_as_integers_do_the_same(clients):
    client = ready(clients("ardupilot", start_up=0.0))
    assert client.command(mavlink.MAV_CMD_DO_SET_MODE, 1.0, GUIDED) == 0
    assert client.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0) == 0

    def take_off(frame: int) -> int:
        client.seen.clear()
        client.send(mavlink.MAVLink_command_int_message(1, 1, frame, 22, 0, 0, 0, 0, 0, 0, 473977420, 85455940, 1.0))
        return client.get("COMMAND_ACK", lambda message: message.command == 22).result

    assert take_off(mavlink.MAV_FRAME_GLOBAL) == mavlink.MAV_RESULT_DENIED
    assert take_off(mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT) == 0
    assert wait_until(lambda: client.emulator.truth.position[2] > 0.9)
    assert wait_until(lambda: not client.emulator.brain.taking_off)


@pytest.mark.parametrize("altitude", [NAN, 490.0])
def test_px4_takes_off_to_its_own_height_or_one_above_the_sea_and_holds(clients, altitude):
    client = ready(clients("px4"))
    assert client.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0) == 0
    assert client.command(mavlink.MAV_CMD_NAV_TAKEOFF, *[NAN] * 6, altitude) == 0
    client.get("EXTENDED_SYS_STATE", lambda message: message.landed_state == mavlink.MAV_LANDED_STATE_TAKEOFF)
    client.get("HEARTBEAT", lambda message: message.custom_mode == px4.LOITER)
    client.get("EXTENDED_SYS_STATE", lambda message: message.landed_state == mavlink.MAV_LANDED_STATE_IN_AIR)
    wanted = 2.5 if math.isnan(altitude) else 2.0
    assert wait_until(lambda: abs(client.emulator.truth.position[2] - wanted) < 0.1)


@pytest.mark.parametrize(("flavour", "armed"), [("px4", 2), ("ardupilot", 4)])
def test_it_reboots_when_told_unless_it_is_armed(clients, flavour, armed):
    client = ready(clients(flavour))
    brain = client.emulator.brain
    brain.armed = True
    assert client.command(mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0) == armed
    brain.armed = False
    assert client.command(mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0) == 0
    assert wait_until(lambda: client.emulator.brain is not brain)
    client.seen.clear()
    client.get("HEARTBEAT")


def test_ardupilot_arms_in_spite_of_its_checks_if_it_must_and_px4_does_not(clients, flavour):
    client = ready(clients(flavour))
    client.emulator.refuse_arming("Compass not healthy")
    number = mavlink.MAV_CMD_COMPONENT_ARM_DISARM
    assert client.command(number, 1.0, 0.0) == client.emulator.brain.refused_result
    assert (client.command(number, 1.0, 21196.0) == 0) == (flavour == "ardupilot")
    assert client.emulator.brain.armed == (flavour == "ardupilot")


def test_px4_ignores_what_is_for_another_component(clients):
    client = ready(clients("px4"))
    client.send(mavlink.MAVLink_command_long_message(1, 240, 400, 0, 1, 0, 0, 0, 0, 0, 0))
    client.send(mavlink.MAVLink_set_attitude_target_message(0, 1, 240, 7, [1, 0, 0, 0], 0, 0, 0, 0.5))
    client.send(mavlink.MAVLink_set_attitude_target_message(0, 1, 0, 7, [1, 0, 0, 0], 0, 0, 0, 0.5))
    assert alive(client)
    assert not client.emulator.brain.armed and len(client.emulator.protocol.setpoint_times) == 1
    assert not [message for message in client.seen if message.get_type() == "COMMAND_ACK"]


# ------------------------------------------------------------ poses


def odometry(stamp: int, frame: int, kind: int, quality: int):
    unknown = [NAN, *[0.0] * 20]
    return mavlink.MAVLink_odometry_message(
        stamp,
        frame,
        mavlink.MAV_FRAME_BODY_FRD,
        0,
        0,
        0,
        [1, 0, 0, 0],
        0,
        0,
        0,
        0,
        0,
        0,
        unknown,
        unknown,
        0,
        kind,
        quality,
    )


@pytest.mark.parametrize(
    ("flavour", "frame", "kind", "taken"),
    [
        ("px4", mavlink.MAV_FRAME_LOCAL_FRD, mavlink.MAV_ESTIMATOR_TYPE_VISION, True),
        ("px4", mavlink.MAV_FRAME_LOCAL_NED, mavlink.MAV_ESTIMATOR_TYPE_VIO, True),
        ("px4", mavlink.MAV_FRAME_LOCAL_FRD, mavlink.MAV_ESTIMATOR_TYPE_MOCAP, False),
        ("ardupilot", mavlink.MAV_FRAME_LOCAL_FRD, mavlink.MAV_ESTIMATOR_TYPE_MOCAP, True),
        ("ardupilot", mavlink.MAV_FRAME_LOCAL_NED, mavlink.MAV_ESTIMATOR_TYPE_VISION, False),
    ],
)
def test_odometry_is_a_pose_in_the_frames_of_each(clients, flavour, frame, kind, taken):
    client = clients(flavour, vision=True)
    client.emulator.parameters["VISO_QUAL_MIN" if flavour == "ardupilot" else "EKF2_EV_CTRL"] = 11
    assert wait_until(lambda: client.emulator.clock > 3.2), "it remembers more than VISO_DELAY_MS"
    stamp = round(client.emulator.clock * 1e6)
    client.send(odometry(stamp, frame, kind, quality=50))
    assert alive(client)
    assert (client.emulator.estimator.accepted_poses == 1) == taken
    client.send(odometry(stamp, frame, kind, quality=5))
    assert alive(client)
    assert client.emulator.estimator.accepted_poses == (2 if flavour == "px4" else 1) * taken
