"""What the link sends where the line is gone, or takes less than it is given; without a thread, on a made-up line."""

from __future__ import annotations

import time
from typing import Any

import pytest
from pixhawk_rig import NO
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.hardware.pixhawk import PixhawkConfig, PositionSetpoint
from doorman.hardware.pixhawk.link.inbox import WANTED
from doorman.hardware.pixhawk.link.link import Link
from doorman.hardware.pixhawk.wire.codec import Codec
from doorman.hardware.pixhawk.wire.messages import command_message


class Noted:
    """A line that notes what it is given."""

    def __init__(self) -> None:
        self.peer, self.busy, self._reader = ("127.0.0.1", 9), False, mavlink.MAVLink(None, 1, 1)
        self.taken: list[Any] = []

    def send(self, data: bytes) -> bool:
        self.taken += self._reader.parse_buffer(data)
        return True

    def close(self) -> None:
        pass


@pytest.fixture
def link() -> Link:
    made = Link(PixhawkConfig("udp:14540", mocap=True, origin=None))
    made.codec = Codec(255, 190, None, WANTED)
    line: Any = Noted()
    made._line = line
    heartbeat = mavlink.MAVLink_heartbeat_message(13, 12, 81, 4 << 16, 3, 3).pack(mavlink.MAVLink(None, 1, 1))
    made.receive(heartbeat, line.peer, line)
    return made


def test_a_busy_line_gets_neither_setpoints_nor_poses_that_would_be_old_when_they_arrive(link: Link) -> None:
    line: Any = link._line
    link.stream.hold(PositionSetpoint(NO, 0.0))
    told: dict[bool, set[str]] = {}
    for busy in (True, False):
        line.busy, now = busy, time.monotonic() + (0.0 if busy else 0.1)
        assert link.mocap.offer(now, NO, [1.0, 0.0, 0.0, 0.0], now)
        line.taken.clear()
        link._send_due(line, now)
        told[busy] = {message.get_type() for message in line.taken}
        assert link._sleep_time(now) > 0.0, "it is not asked again and again"
    wanted = {"SET_POSITION_TARGET_LOCAL_NED", "VISION_POSITION_ESTIMATE"}
    assert "HEARTBEAT" in told[True]
    assert not told[True] & wanted
    assert wanted <= told[False]


def test_nothing_waits_for_a_line_that_is_gone(link: Link) -> None:
    """A vehicle must not arm when its cable is plugged in again."""
    line: Any = link._line
    arming = command_message((1, 1), mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)

    def arms() -> int:
        line.taken.clear()
        link._send_due(line, time.monotonic())
        return sum(getattr(message, "command", None) == arming.command for message in line.taken)

    link.send(arming)
    assert arms() == 1
    link.send(arming)
    link._lose_device(OSError("unplugged"))
    link.send(arming)
    link._line = line
    assert arms() == 0
