"""The emulated autopilot against a client of a few lines: it must be as strict as the documents of the real ones say."""

from __future__ import annotations

import pytest
from pixhawk_rig import wait_until
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.exceptions import BackendError
from doorman.rig.emulators.autopilot import EmulatedAutopilot
from doorman.rig.emulators.autopilot.dialects import PX4


def test_px4_speaks_first_and_ardupilot_says_nothing_but_its_heartbeat(clients):
    client = clients("px4")
    for kind in ("HEARTBEAT", "ATTITUDE_QUATERNION", "LOCAL_POSITION_NED", "SYS_STATUS"):
        client.get(kind)
    heartbeat = client.get("HEARTBEAT")
    assert (heartbeat.autopilot, heartbeat.type, heartbeat.custom_mode) == (12, 13, PX4.modes["loiter"])
    client = clients("ardupilot")
    for _ in range(3):
        client.get("HEARTBEAT")
        client.seen.clear()
    assert {message.get_type() for message in client.seen} <= {"HEARTBEAT", "TIMESYNC"}
    assert client.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 32.0, 10_000.0) == 0
    client.get("LOCAL_POSITION_NED")
    assert client.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 230.0, 10_000.0) == 2
    assert client.command(31000) == 3


def test_it_answers_for_the_clock(clients):
    client = clients("px4")
    client.send(mavlink.MAVLink_timesync_message(0, 123456789))
    answer = client.get("TIMESYNC", lambda message: message.ts1 == 123456789)
    assert answer.tc1 * 1e-9 <= client.emulator.clock.now


@pytest.mark.parametrize(("flavour", "name"), [("px4", "COM_OBL_RC_ACT"), ("ardupilot", "FS_GCS_ENABLE")])
def test_integer_parameters_travel_as_each_of_them_does_it(clients, flavour, name):
    client = clients(flavour)
    client.emulator.parameters[name] = 5
    client.send(mavlink.MAVLink_param_request_read_message(1, 1, name.encode(), -1))
    value = client.get("PARAM_VALUE")
    assert (value.param_value == 5.0) == (flavour == "ardupilot")
    client.send(mavlink.MAVLink_param_set_message(1, 1, name.encode(), value.param_value, value.param_type))
    assert wait_until(lambda: client.emulator.parameters.writes == 1)
    assert client.emulator.parameters[name] == 5.0


def test_messages_to_other_systems_are_not_for_it(clients):
    client = clients("px4")
    client.send(mavlink.MAVLink_param_set_message(9, 1, b"COM_DL_LOSS_T", 0.0, 6))
    client.send(mavlink.MAVLink_command_long_message(9, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0))
    client.send(mavlink.MAVLink_timesync_message(0, 77))
    client.get("TIMESYNC", lambda message: message.ts1 == 77)
    assert client.emulator.parameters.writes == 0 and not client.emulator.brain.armed
    assert client.emulator.receiver.received["COMMAND_LONG"] == 0


@pytest.mark.parametrize(("flavour", "result"), [("px4", 0), ("ardupilot", 2)])
def test_no_number_is_no_place_for_ardupilot(clients, flavour, result):
    """Before 4.5 it makes an integer of it, which in simulation ends it."""
    client = clients(flavour)
    nan = float("nan")
    assert client.command(mavlink.MAV_CMD_NAV_LAND, 0.0, 0.0, 0.0, nan, nan, nan) == result
    assert client.command(mavlink.MAV_CMD_NAV_LAND) == 0


def test_px4_says_nothing_of_its_checks_before_it_is_to_arm(clients):
    bit = mavlink.MAV_SYS_STATUS_PREARM_CHECK
    status = clients("px4").get("SYS_STATUS", lambda message: message.onboard_control_sensors_health & bit)
    assert not (status.onboard_control_sensors_enabled | status.onboard_control_sensors_present) & bit


def test_noise_does_not_stop_it(clients):
    client = clients("ardupilot")
    for size in (1, 3, 50, 300):
        client.socket.sendto(bytes(range(256))[:size] * 2, client.emulator.address)
    client.send(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    for stamp in range(5):
        client.send(mavlink.MAVLink_timesync_message(0, 5 + stamp))
    client.get("TIMESYNC", lambda message: 5 <= message.ts1 < 10)


def test_it_binds_nothing_but_loopback():
    for settings in ({"local": ("0.0.0.0", 0)}, {"remote": ("192.168.1.1", 14550)}):
        with pytest.raises(BackendError, match="loopback"):
            EmulatedAutopilot("px4", **settings).open()  # type: ignore[arg-type]
    with pytest.raises(BackendError, match="px4 or ardupilot"):
        EmulatedAutopilot("betaflight")  # type: ignore[arg-type]


def test_a_reboot_starts_everything_anew(clients):
    client = clients("ardupilot")
    client.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 32.0, 10_000.0)
    client.get("LOCAL_POSITION_NED")
    client.emulator.brain.armed = True
    client.get("HEARTBEAT", lambda message: message.base_mode & 128)
    client.emulator.clock.jumped += 100.0
    client.emulator.reboot(silence=0.1)
    client.get("HEARTBEAT", lambda message: not message.base_mode & 128)
    assert client.emulator.clock.now < 100.0
    client.seen.clear()
    client.get("HEARTBEAT")
    assert not [message for message in client.seen if message.get_type() == "LOCAL_POSITION_NED"]
