"""The emulated autopilot against a client of a few lines: it must be as strict as the documents of the real ones say."""

from __future__ import annotations

import socket
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from pixhawk_rig import free_port, wait_until
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from virtual_time import CLOCK

from doorman.exceptions import BackendError
from doorman.rig.emulators.autopilot import EmulatedAutopilot
from doorman.rig.emulators.autopilot.dialects import PX4


class Client:
    """A ground station of a few lines, written with pymavlink alone."""

    def __init__(self, emulator: EmulatedAutopilot, port: int) -> None:
        self.mav = mavlink.MAVLink(None, 255, 190)
        self.mav.robust_parsing = True
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", port))
        self.socket.setblocking(False)
        self.emulator = emulator
        self.seen: list[Any] = []

    def send(self, message: Any) -> None:
        self.socket.sendto(message.pack(self.mav), self.emulator.address)

    def command(self, number: int, *values: float) -> int:
        padded = [*values, *[0.0] * (7 - len(values))]
        self.seen.clear()
        self.send(mavlink.MAVLink_command_long_message(1, 1, number, 0, *padded))
        return int(self.get("COMMAND_ACK", lambda message: message.command == number).result)

    def get(self, kind: str, accept: Callable[[Any], bool] = lambda message: True) -> Any:
        found: list[Any] = []

        def look() -> bool:
            try:
                while True:
                    self.seen += self.mav.parse_buffer(self.socket.recv(65536)) or []
            except BlockingIOError:
                pass
            found.extend(message for message in self.seen if message.get_type() == kind and accept(message))
            return bool(found)

        assert wait_until(look), f"no {kind}"
        return found[-1]


@pytest.fixture
def clients() -> Iterator[Callable[..., Client]]:
    """Makes emulated autopilots with a client each, which end with the test."""
    made: list[Client] = []

    def make(flavour: str, **settings: Any) -> Client:
        port = free_port()
        emulator = EmulatedAutopilot(flavour, remote=("127.0.0.1", port), heartbeat_rate=10.0, clock=CLOCK, **settings)  # type: ignore[arg-type]
        emulator.open()
        made.append(Client(emulator, port))
        return made[-1]

    yield make
    for client in made:
        client.emulator.stop()
        client.emulator.stop()
        client.socket.close()


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


def test_it_binds_nothing_but_loopback():
    for settings in ({"local": ("0.0.0.0", 0)}, {"remote": ("192.168.1.1", 14550)}):
        with pytest.raises(BackendError, match="loopback"):
            EmulatedAutopilot("px4", **settings).open()  # type: ignore[arg-type]
    with pytest.raises(BackendError, match="px4 or ardupilot"):
        EmulatedAutopilot("betaflight")  # type: ignore[arg-type]
