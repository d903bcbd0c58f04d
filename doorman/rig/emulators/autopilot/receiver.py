"""What the emulated autopilot does with messages that it receives: commands, parameters, clock, setpoints and poses."""

from __future__ import annotations

import math
import struct
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.arrays import Array
from doorman.rig.emulators.autopilot.brain import Brain
from doorman.rig.emulators.autopilot.control import Demand, Task
from doorman.rig.emulators.autopilot.dialects import ACCEPTED, DENIED, UNSUPPORTED, Dialect, ParameterStore
from doorman.rig.emulators.autopilot.estimator import FLIP, FLIP_QUATERNION, NOTHING, Estimator, thrust_axis
from doorman.rig.emulators.autopilot.line import BootClock, CompanionClock
from doorman.rig.emulators.autopilot.telemetry import Telemetry

_FORCE = 21196
"""Second parameter of a command that disarms even in the air."""


class Receiver:
    def __init__(
        self, brain: Brain, estimator: Estimator, telemetry: Telemetry, clock: BootClock, system_id: int
    ) -> None:
        self.received: Counter[str] = Counter()  # messages by type
        self.commands: Counter[int] = Counter()  # commands by MAV_CMD
        self.heartbeat_types: set[tuple[int, int, int]] = set()  # system, component and MAV_TYPE of heartbeats
        self.station_heard = -math.inf  # last heartbeat of a ground station, by its uptime [s]
        self.mute_commands = self.ignore_commands = 0
        """Commands that are to be executed but not acknowledged, and to be lost."""
        self.companion_clock = CompanionClock(brain.dialect.asks_time)
        self._brain, self._estimator, self._telemetry, self._clock = brain, estimator, telemetry, clock
        self._system, self._parameters, self._dialect = system_id, brain.parameters, brain.dialect
        self._handlers: dict[str, Callable[[Any], None]] = {
            "HEARTBEAT": self._heartbeat,
            "COMMAND_LONG": self._command,
            "PARAM_REQUEST_READ": lambda message: self._send_parameter(message.param_id),
            "PARAM_SET": self._parameter_set,
            "TIMESYNC": self._timesync,
            "SET_ATTITUDE_TARGET": lambda m: brain.aim(attitude_demand(brain.dialect, brain.parameters, m)),
            "SET_POSITION_TARGET_LOCAL_NED": lambda message: brain.aim(position_demand(message)),
            "VISION_POSITION_ESTIMATE": self._vision,
            "SET_GPS_GLOBAL_ORIGIN": self._origin,
        }

    def take(self, message: Any) -> None:
        """Act on a message; one to another system is ignored."""
        if getattr(message, "target_system", 0) in (0, self._system):
            self.received[message.get_type()] += 1
            self._handlers.get(message.get_type(), lambda message: None)(message)

    def _heartbeat(self, message: Any) -> None:
        system = message.get_srcSystem()
        self.heartbeat_types.add((system, message.get_srcComponent(), message.type))
        heeded = self._parameters.get("SYSID_MYGCS", -1)
        if system == heeded or (heeded < 0 and message.type == mavlink.MAV_TYPE_GCS):
            self.station_heard = self._clock.uptime

    # ------------------------------------------------------------ commands

    def _command(self, message: Any) -> None:
        self.commands[message.command] += 1
        if self.ignore_commands > 0:
            self.ignore_commands -= 1
            return
        result = self._execute(message.command, [getattr(message, f"param{number}") for number in range(1, 8)])
        if self.mute_commands > 0:
            self.mute_commands -= 1
            return
        sender = message.get_srcSystem(), message.get_srcComponent()
        self._telemetry.send(mavlink.MAVLink_command_ack_message(message.command, result, 0, 0, *sender))

    def _execute(self, command: int, values: list[float]) -> int:
        """Do it; returns a MAV_RESULT."""
        # ArduPilot before 4.5 makes integers of the fifth and sixth value, which in simulation ends it where they are
        # not numbers.
        brain, first = self._brain, values[0]
        read = values[:3] if self._dialect.heeds_stream else [*values[:3], *values[4:6]]
        if not all(map(math.isfinite, read)):
            return DENIED
        match command:
            case mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
                return self._set_interval(int(first), values[1])
            case mavlink.MAV_CMD_REQUEST_MESSAGE:
                return ACCEPTED if self._telemetry.tell(int(first)) else self._dialect.refusal
            case mavlink.MAV_CMD_DO_SET_MODE:
                main, sub = self._dialect.mode_bits
                return brain.request_mode(main * int(values[1]) + sub * int(values[2]))
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
        most = self._dialect.share_of_loop * self._parameters.get("SCHED_LOOP_RATE", math.inf)
        if interval_us > 0.0 and 1e6 / interval_us > most:
            return self._dialect.refusal
        return ACCEPTED if self._telemetry.set_interval(identifier, interval_us) else DENIED

    # ------------------------------------------------------------ parameters, clock and poses

    def _parameter_set(self, message: Any) -> None:
        if self._parameters.from_wire(message.param_id, message.param_value, message.param_type):
            self._send_parameter(message.param_id)

    def _send_parameter(self, name: str) -> None:
        if name in self._parameters:
            names, (value, kind) = self._parameters.names, self._parameters.to_wire(name)
            place = len(names), names.index(name)
            self._telemetry.send(mavlink.MAVLink_param_value_message(name.encode(), value, kind, *place))

    def _timesync(self, message: Any) -> None:
        now_ns = round(self._clock.now * 1e9)
        if message.tc1 == 0:
            self._telemetry.send(mavlink.MAVLink_timesync_message(now_ns, message.ts1))
        else:
            self.companion_clock.answer(message.ts1, message.tc1, now_ns)

    def _vision(self, message: Any) -> None:
        """Fuse a pose. It has no quality, which ArduPilot may ask for, and ArduPilot takes its delay from a parameter."""
        position = np.array([message.x, message.y, message.z]) * FLIP
        if np.isfinite(position).all() and self._parameters.get("VISO_QUAL_MIN", 0.0) <= 0:
            now, uptime = self._clock.now, self._clock.uptime
            delay = 1e-3 * self._parameters.get("VISO_DELAY_MS", 0.0)
            self._estimator.pose(uptime, uptime - now + self.companion_clock.stamp(message.usec, now) - delay, position)

    def _origin(self, message: Any) -> None:
        """PX4 takes every one, ArduPilot the first."""
        if self._estimator.origin is None or self._dialect.heeds_stream:
            place = message.latitude, message.longitude, message.altitude
            self._estimator.set_origin(self._clock.uptime, self._brain.armed, place)
            self._telemetry.send(mavlink.MAVLink_gps_global_origin_message(*place))


_RATES, _UNUSED, _THRUST_BODY = 7, 0x40 | 0x80, 0x20
"""Bits of SET_ATTITUDE_TARGET: body rates are ignored; thrust or attitude are; thrust is a vector in the body."""
_THRUST_AS_THRUST = 8
"""Bit of GUID_OPTIONS; without it, thrust is a climb rate, which doorman does not use."""


def attitude_demand(dialect: Dialect, parameters: ParameterStore, message: Any) -> Demand | None:
    """SET_ATTITUDE_TARGET."""
    mask, quaternion, thrust = message.type_mask, np.array(message.q) * FLIP_QUATERNION, message.thrust
    x = y = 0.0
    if mask & _THRUST_BODY and dialect.takes_body_thrust:
        x, y, thrust = (_thrust_body(message) * FLIP).tolist()
    unit = abs(float(np.linalg.norm(quaternion)) - 1.0) <= 1e-3
    takes = int(parameters.get("GUID_OPTIONS", _THRUST_AS_THRUST)) & _THRUST_AS_THRUST
    if mask & (_RATES | _UNUSED) != _RATES or not unit or not np.isfinite([thrust, x, y]).all() or not takes:
        return None
    thrust = min(max(thrust, 0.0), 1.0)
    if parameters.get("ATC_ANGLE_BOOST", 0.0):
        thrust = min(1.0, thrust / min(max(float(thrust_axis(quaternion)[2]), 0.1), 1.0))
    return Demand(Task.ATTITUDE, quaternion=quaternion, thrust=thrust, side=(x, y))


def position_demand(message: Any) -> Demand | None:
    """SET_POSITION_TARGET_LOCAL_NED: a position, a velocity or both."""
    mask, yaw = message.type_mask, -message.yaw
    position, velocity, acceleration = (
        NOTHING if mask & ignored else np.array(values) * FLIP
        for ignored, values in (
            (0x7, (message.x, message.y, message.z)),
            (0x38, (message.vx, message.vy, message.vz)),
            (0x1C0, (message.afx, message.afy, message.afz)),
        )
    )
    finite = np.isfinite([position, velocity, acceleration]).all()
    if message.coordinate_frame != mavlink.MAV_FRAME_LOCAL_NED or (mask & 0x7 and mask & 0x38) or not finite:
        return None
    heading = None if mask & 0x400 or not math.isfinite(yaw) else yaw
    task = Task.VELOCITY if mask & 0x7 else Task.POSITION
    return Demand(task, position=position, velocity=velocity, acceleration=acceleration, yaw=heading)


def _thrust_body(message: Any) -> Array:
    """Extension of SET_ATTITUDE_TARGET that the dialect here does not have; zeros where it was not sent, or cut off as such."""
    frame = bytes(message.get_msgbuf())
    known, payload = message.unpacker.size, frame[10 : 10 + frame[1]] if frame[0] == 0xFD else b""
    return np.array(struct.unpack("<3f", payload[known : known + 12].ljust(12, b"\0")))
