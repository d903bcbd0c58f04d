"""What the emulated autopilot does with messages that it receives: commands, parameters, clock, setpoints and poses."""

from __future__ import annotations

import math
import struct
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot.brain import Brain
from doorman.rig.emulators.autopilot.clock import Clock, CompanionClock
from doorman.rig.emulators.autopilot.dialects import ACCEPTED, DENIED, UNSUPPORTED
from doorman.rig.emulators.autopilot.estimator import Estimator
from doorman.rig.emulators.autopilot.plant import Array
from doorman.rig.emulators.autopilot.telemetry import FLIP, FLIP_QUATERNION, Telemetry

_FORCE = 21196.0
"""Disarms in the air, too."""
_SHARE_OF_LOOP = 0.8
"""Of ArduPilot's main loop, up to which a message is sent."""


class Protocol:
    """Handles received messages.

    Args:
        brain: Modes and rules.
        estimator: Takes poses.
        telemetry: Sends answers.
        clock: Its own.
        system_id: Its own.
    """

    def __init__(self, brain: Brain, estimator: Estimator, telemetry: Telemetry, clock: Clock, system_id: int) -> None:
        self.received: Counter[str] = Counter()
        """Messages by type."""
        self.commands: Counter[int] = Counter()
        """Commands by MAV_CMD."""
        self.heartbeat_types: set[tuple[int, int, int]] = set()
        """System, component and MAV_TYPE of heartbeats."""
        self.station_heard = float("-inf")
        """Last heartbeat of a ground station, by its uptime [s]."""
        self.mute_commands = 0  # to be executed but not acknowledged
        self.ignore_commands = 0  # to be lost
        self.companion_clock = CompanionClock(brain.dialect.asks_time)
        self._brain, self._estimator, self._telemetry, self._clock = brain, estimator, telemetry, clock
        self._system = system_id
        self._handlers: dict[str, Callable[[Any], None]] = {
            "HEARTBEAT": self._heartbeat,
            "COMMAND_LONG": self._command,
            "PARAM_REQUEST_READ": self._parameter_read,
            "PARAM_SET": self._parameter_set,
            "TIMESYNC": self._timesync,
            "SET_ATTITUDE_TARGET": self._attitude_target,
            "SET_POSITION_TARGET_LOCAL_NED": self._position_target,
            "VISION_POSITION_ESTIMATE": self._vision,
            "SET_GPS_GLOBAL_ORIGIN": self._origin,
        }

    def take(self, message: Any) -> None:
        """Act on a message; one to another system is ignored.

        Args:
            message: Of pymavlink.
        """
        if getattr(message, "target_system", 0) not in (0, self._system):
            return
        self.received[message.get_type()] += 1
        handler = self._handlers.get(message.get_type())
        if handler is not None:
            handler(message)

    def _heartbeat(self, message: Any) -> None:
        self.heartbeat_types.add((message.get_srcSystem(), message.get_srcComponent(), message.type))
        parameters = self._brain.parameters
        heeds_id = "SYSID_MYGCS" in parameters
        if message.get_srcSystem() == parameters["SYSID_MYGCS"] if heeds_id else message.type == mavlink.MAV_TYPE_GCS:
            self.station_heard = self._clock.uptime

    # ------------------------------------------------------------ commands

    def _command(self, message: Any) -> None:
        self.commands[message.command] += 1
        if self.ignore_commands > 0:
            self.ignore_commands -= 1
            return
        values = [getattr(message, f"param{number}") for number in range(1, 8)]
        result = self._execute(message.command, values)
        if self.mute_commands > 0:
            self.mute_commands -= 1
            return
        sender = message.get_srcSystem(), message.get_srcComponent()
        self._telemetry.send(mavlink.MAVLink_command_ack_message(message.command, result, 0, 0, *sender))

    def _execute(self, command: int, values: list[float]) -> int:
        """Do it; returns a MAV_RESULT.

        ArduPilot before 4.5 makes integers of the fifth and sixth value, which in simulation ends it where they are not numbers.
        """
        brain, first = self._brain, values[0]
        read = values[:3] if brain.dialect.heeds_stream else [*values[:3], *values[4:6]]
        if not all(map(math.isfinite, read)):
            return DENIED
        match command:
            case mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
                return self._set_interval(int(first), values[1])
            case mavlink.MAV_CMD_REQUEST_MESSAGE:
                return ACCEPTED if self._telemetry.tell(int(first)) else brain.dialect.refusal
            case mavlink.MAV_CMD_DO_SET_MODE:
                return brain.request_mode(brain.dialect.number(*map(int, values[1:3])))
            case mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
                return brain.request_arming(first > 0.5, values[1] == _FORCE)
            case mavlink.MAV_CMD_RUN_PREARM_CHECKS:
                brain.arming_refused()
                return ACCEPTED
            case mavlink.MAV_CMD_NAV_TAKEOFF:
                return brain.request_take_off(values[6])
            case mavlink.MAV_CMD_NAV_LAND:
                return brain.request_land()
        return UNSUPPORTED

    def _set_interval(self, identifier: int, interval_us: float) -> int:
        """ArduPilot sends nothing more often than its main loop allows."""
        parameters = self._brain.parameters
        most = _SHARE_OF_LOOP * parameters["SCHED_LOOP_RATE"] if "SCHED_LOOP_RATE" in parameters else math.inf
        if interval_us > 0.0 and 1e6 / interval_us > most:
            return self._brain.dialect.refusal
        return ACCEPTED if self._telemetry.schedule.set_interval(identifier, interval_us) else DENIED

    # ------------------------------------------------------------ parameters and clock

    def _parameter_read(self, message: Any) -> None:
        if message.param_id in self._brain.parameters:
            self._send_parameter(message.param_id)

    def _parameter_set(self, message: Any) -> None:
        if self._brain.parameters.from_wire(message.param_id, message.param_value, message.param_type):
            self._send_parameter(message.param_id)

    def _send_parameter(self, name: str) -> None:
        names, (value, kind) = self._brain.parameters.names, self._brain.parameters.to_wire(name)
        self._telemetry.send(
            mavlink.MAVLink_param_value_message(name.encode(), value, kind, len(names), names.index(name))
        )

    def _timesync(self, message: Any) -> None:
        now_ns = round(self._clock.now * 1e9)
        if message.tc1 == 0:
            self._telemetry.send(mavlink.MAVLink_timesync_message(now_ns, message.ts1))
        else:
            self.companion_clock.answer(message.ts1, message.tc1, now_ns)

    # ------------------------------------------------------------ setpoints and poses

    def _attitude_target(self, message: Any) -> None:
        quaternion, body = np.array(message.q) * FLIP_QUATERNION, thrust_body(message) * FLIP
        self._brain.attitude_target(message.type_mask, quaternion, message.thrust, body)

    def _position_target(self, message: Any) -> None:
        position, velocity, acceleration = (
            np.array(values) * FLIP
            for values in (
                (message.x, message.y, message.z),
                (message.vx, message.vy, message.vz),
                (message.afx, message.afy, message.afz),
            )
        )
        frame = message.coordinate_frame
        self._brain.position_target(message.type_mask, frame, position, velocity, acceleration, -message.yaw)

    def _vision(self, message: Any) -> None:
        """Fuse a pose. It has no quality, which ArduPilot may ask for, and ArduPilot takes its delay from a parameter."""
        parameters, position = self._brain.parameters, np.array([message.x, message.y, message.z]) * FLIP
        if not np.isfinite(position).all() or ("VISO_QUAL_MIN" in parameters and parameters["VISO_QUAL_MIN"] > 0):
            return
        now, uptime = self._clock.now, self._clock.uptime
        delay = 1e-3 * parameters["VISO_DELAY_MS"] if "VISO_DELAY_MS" in parameters else 0.0
        self._estimator.pose(uptime, uptime - now + self.companion_clock.stamp(message.usec, now) - delay, position)

    def _origin(self, message: Any) -> None:
        """PX4 takes every one, ArduPilot the first."""
        if self._estimator.origin is None or self._brain.dialect.heeds_stream:
            place = message.latitude, message.longitude, message.altitude
            self._estimator.set_origin(self._clock.uptime, self._brain.armed, place)
            self._telemetry.send(mavlink.MAVLink_gps_global_origin_message(*place))


def thrust_body(message: Any) -> Array:
    """Extension of SET_ATTITUDE_TARGET that the dialect here does not have; zeros where it was not sent, or cut off as such.

    Args:
        message: As decoded.

    Returns:
        Normalised, in the body, z down, shape (3,).
    """
    frame = bytes(message.get_msgbuf())
    known, payload = message.unpacker.size, frame[10 : 10 + frame[1]] if frame[0] == 0xFD else b""
    return np.array(struct.unpack("<3f", payload[known : known + 12].ljust(12, b"\0")))
