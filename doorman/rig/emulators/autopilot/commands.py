"""Commands that the emulated autopilot executes, and how it refuses them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot.brain import (
    ACCEPTED,
    DENIED,
    FAILED,
    TEMPORARILY_REJECTED,
    UNSUPPORTED,
    Brain,
)
from doorman.rig.emulators.autopilot.estimator import Estimator
from doorman.rig.emulators.autopilot.schedule import Schedule

_FORCE, _FORCE_ARMING = 21196.0, 2989.0
_SHARE_OF_LOOP = 0.8
"""Of ArduPilot's main loop, up to which a message is sent."""
_NO_PLACE = 0x7FFFFFFF
_LOCAL_FRAMES = (
    mavlink.MAV_FRAME_LOCAL_NED,
    mavlink.MAV_FRAME_LOCAL_ENU,
    mavlink.MAV_FRAME_LOCAL_OFFSET_NED,
    mavlink.MAV_FRAME_BODY_NED,
    mavlink.MAV_FRAME_BODY_OFFSET_NED,
    mavlink.MAV_FRAME_BODY_FRD,
    mavlink.MAV_FRAME_LOCAL_FRD,
    mavlink.MAV_FRAME_LOCAL_FLU,
)
_READ = {
    mavlink.MAV_CMD_SET_MESSAGE_INTERVAL: 2,
    mavlink.MAV_CMD_REQUEST_MESSAGE: 1,
    mavlink.MAV_CMD_DO_SET_MODE: 3,
    mavlink.MAV_CMD_COMPONENT_ARM_DISARM: 1,
    mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: 1,
}
"""How many of a command's parameters have to be numbers."""


@dataclass(frozen=True)
class Command:
    """A decoded COMMAND_LONG or COMMAND_INT."""

    number: int
    """MAV_CMD."""
    values: tuple[float, ...]
    """The seven parameters."""
    frame: int | None = None
    """MAV_FRAME of a COMMAND_INT."""

    @classmethod
    def of(cls, message: Any) -> Command:
        """What such a message says."""
        first = (message.param1, message.param2, message.param3, message.param4)
        if message.get_type() == "COMMAND_LONG":
            return cls(message.command, (*first, message.param5, message.param6, message.param7))
        if message.x == message.y == _NO_PLACE:
            place = math.nan, math.nan
        else:
            scale = 1e4 if message.frame in _LOCAL_FRAMES else 1e7
            place = message.x / scale, message.y / scale
        return cls(message.command, (*first, *place, message.z), message.frame)


class Commands:
    """Executes commands.

    Args:
        brain: Modes and rules.
        estimator: Knows the origin.
        schedule: Of the telemetry.
        tell: Sends the message of an identifier; False if there is none.
    """

    def __init__(self, brain: Brain, estimator: Estimator, schedule: Schedule, tell: Callable[[int], bool]) -> None:
        self.reboots = False
        """Whether it was told to reboot."""
        self._brain, self._estimator, self._schedule, self._tell = brain, estimator, schedule, tell
        self._px4 = brain.vendor == mavlink.MAV_AUTOPILOT_PX4
        self._handlers: dict[int, Callable[[Command], int]] = {
            mavlink.MAV_CMD_DO_SET_MODE: lambda command: brain.request_mode(command.values[:3]),
            mavlink.MAV_CMD_COMPONENT_ARM_DISARM: self._arm,
            mavlink.MAV_CMD_RUN_PREARM_CHECKS: self._check,
            mavlink.MAV_CMD_NAV_TAKEOFF: self._take_off,
            mavlink.MAV_CMD_NAV_LAND: lambda command: brain.request_land(),
            mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH: lambda command: brain.request_return(),
            mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: self._reboot,
        }

    def execute(self, command: Command) -> int:
        """Do it; returns a MAV_RESULT."""
        if self._stumbles(command) or not all(map(math.isfinite, command.values[: _READ.get(command.number, 0)])):
            return DENIED
        if command.number == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
            return self._set_interval(int(command.values[0]), command.values[1])
        if command.number == mavlink.MAV_CMD_REQUEST_MESSAGE:
            identifier = int(command.values[0])
            told = identifier in self._schedule.settable and self._tell(identifier)
            return ACCEPTED if told else DENIED if self._px4 else FAILED
        if self._brain.around is None:
            return TEMPORARILY_REJECTED
        handler = self._handlers.get(command.number)
        return UNSUPPORTED if handler is None else handler(command)

    @property
    def most_often(self) -> float:
        """How often ArduPilot's main loop can send a message [1/s]."""
        return _SHARE_OF_LOOP * self._brain.parameters["SCHED_LOOP_RATE"]

    def _stumbles(self, command: Command) -> bool:
        """Whether ArduPilot before 4.5 would make integers of what is none, which aborts it in simulation."""
        if self._px4:
            return False
        return command.frame is None and (math.isnan(command.values[4]) or math.isnan(command.values[5]))

    def _set_interval(self, identifier: int, interval_us: float) -> int:
        if not self._px4 and interval_us > 0.0 and 1e6 / interval_us > self.most_often:
            return FAILED
        return ACCEPTED if self._schedule.set_interval(identifier, interval_us) else DENIED

    def _arm(self, command: Command) -> int:
        arm, magic = command.values[0] > 0.5, command.values[1]
        return self._brain.request_arming(arm, magic == _FORCE or (arm and magic == _FORCE_ARMING))

    def _check(self, command: Command) -> int:
        if self._brain.armed:
            return TEMPORARILY_REJECTED
        self._brain.check_arming()
        return ACCEPTED

    def _take_off(self, command: Command) -> int:
        """PX4 takes the altitude for one above the sea, and none for its parameter's; ArduPilot for one above home."""
        height, origin = command.values[6], self._estimator.origin
        if self._px4:
            return self._brain.request_take_off(height - (0.0 if origin is None else origin.altitude))
        if command.frame not in (None, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT) or not math.isfinite(height):
            return DENIED
        return self._brain.request_take_off(height)

    def _reboot(self, command: Command) -> int:
        """Once the command is acknowledged; not while it is armed."""
        action = int(command.values[0])
        if self._brain.armed:
            return DENIED if self._px4 else FAILED
        if action != 1:
            return UNSUPPORTED if not self._px4 else DENIED if action else ACCEPTED
        self.reboots = True
        return ACCEPTED
