"""What the emulated autopilot does with messages that it receives: commands, parameters, clock, setpoints and poses."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.hardware.emulators.autopilot_brain import (
    ACCEPTED,
    DENIED,
    FAILED,
    TEMPORARILY_REJECTED,
    UNSUPPORTED,
    AttitudeTarget,
    Brain,
    PositionTarget,
)
from doorman.hardware.emulators.autopilot_estimator import Estimator
from doorman.hardware.emulators.autopilot_telemetry import FLIP, FLIP_QUATERNION, Schedule, estimator_status

_FORCE_MAGIC = 21196.0
_SHARE_OF_LOOP = 0.8
"""Of ArduPilot's main loop, up to which a message is sent."""


class ClockOfOthers:
    """Maps stamps of a companion to the autopilot's clock, the way the two autopilots do it.

    Args:
        by_timesync: By its own TIMESYNC requests (PX4), or by the least lag that was seen (ArduPilot).
        needed: Answers before a mapping is trusted.
    """

    def __init__(self, by_timesync: bool, needed: int = 20) -> None:
        self.answers = 0
        self.offset = 0.0
        """The autopilot's clock minus the companion's [s]."""
        self._by_timesync = by_timesync
        self._needed = needed
        self._least: float | None = None

    def answer(self, sent_ns: int, companion_ns: int, now_ns: int) -> None:
        """An answer to our request."""
        offset = ((sent_ns + now_ns) / 2 - companion_ns) * 1e-9
        self.offset = offset if self.answers == 0 else 0.8 * self.offset + 0.2 * offset
        self.answers += 1

    def stamp(self, companion_us: int, now: float) -> float:
        """Time on the autopilot's clock [s] of a companion's stamp that arrives now."""
        stamp = companion_us * 1e-6
        if self._by_timesync:
            return stamp + self.offset if self.answers >= self._needed else now
        lag = now - stamp
        self._least = lag if self._least is None else min(self._least + 1e-5, lag)
        return stamp + self._least


class Protocol:
    """Handles received messages.

    Args:
        brain: Modes and rules.
        estimator: Takes poses.
        schedule: Of the telemetry.
        send: Sends a message.
        clock: The autopilot's clock, of its stamps [s].
        uptime: The one of its time-outs, which does not jump [s].
        system_id: Of the vehicle.
    """

    def __init__(
        self,
        brain: Brain,
        estimator: Estimator,
        schedule: Schedule,
        send: Callable[[Any], None],
        clock: Callable[[], float],
        uptime: Callable[[], float],
        system_id: int,
    ) -> None:
        self.received: Counter[str] = Counter()
        """Messages by type."""
        self.heartbeat_types: set[tuple[int, int, int]] = set()
        """System, component and MAV_TYPE of heartbeats."""
        self.station_heard = float("-inf")
        """Last heartbeat of a ground station, by its uptime [s]."""
        self.setpoint_times: list[float] = []
        """When setpoints came, by `time.monotonic()`; the newest 5000."""
        self.mute_commands = 0  # to be executed but not acknowledged
        self.ignore_commands = 0  # to be lost
        self.companion_clock = ClockOfOthers(brain.vendor == mavlink.MAV_AUTOPILOT_PX4)
        self._brain = brain
        self._estimator = estimator
        self._schedule = schedule
        self._send = send
        self._clock, self._uptime = clock, uptime
        self._system = system_id
        self._origin_message: Any = None
        self._handlers: dict[str, Callable[[Any], None]] = {
            "HEARTBEAT": self._heartbeat,
            "COMMAND_LONG": self._command,
            "PARAM_REQUEST_READ": self._parameter_read,
            "PARAM_REQUEST_LIST": self._parameter_list,
            "PARAM_SET": self._parameter_set,
            "TIMESYNC": self._timesync,
            "SET_ATTITUDE_TARGET": self._attitude_target,
            "SET_POSITION_TARGET_LOCAL_NED": self._position_target,
            "VISION_POSITION_ESTIMATE": self._vision,
            "SET_GPS_GLOBAL_ORIGIN": self._origin,
            "REQUEST_DATA_STREAM": self._data_stream,
        }

    def take(self, message: Any) -> None:
        """Act on a message; those to other systems are not for us."""
        if getattr(message, "target_system", 0) not in (0, self._system):
            return
        self.received[message.get_type()] += 1
        handler = self._handlers.get(message.get_type())
        if handler is not None:
            handler(message)

    def _heartbeat(self, message: Any) -> None:
        self.heartbeat_types.add((message.get_srcSystem(), message.get_srcComponent(), message.type))
        if self._brain.vendor == mavlink.MAV_AUTOPILOT_PX4:
            from_station = message.type == mavlink.MAV_TYPE_GCS
        else:
            from_station = message.get_srcSystem() == int(self._brain.parameters["SYSID_MYGCS"])
        if from_station:
            self.station_heard = self._uptime()

    def _command(self, message: Any) -> None:
        if self.ignore_commands > 0:
            self.ignore_commands -= 1
            return
        result = self._execute(message)
        if self.mute_commands > 0:
            self.mute_commands -= 1
            return
        self._send(
            mavlink.MAVLink_command_ack_message(
                message.command, result, 0, 0, message.get_srcSystem(), message.get_srcComponent()
            )
        )

    def _execute(self, message: Any) -> int:
        brain = self._brain
        if self._stumbles(message):
            return DENIED
        if message.command == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
            if self._too_fast(message.param2):
                return FAILED
            return ACCEPTED if self._schedule.set_interval(int(message.param1), message.param2) else DENIED
        if message.command == mavlink.MAV_CMD_REQUEST_MESSAGE:
            return self._tell(int(message.param1))
        if brain.around is None:
            return TEMPORARILY_REJECTED
        if message.command == mavlink.MAV_CMD_DO_SET_MODE:
            return brain.request_mode((message.param1, message.param2, message.param3))
        if message.command == mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
            return brain.request_arming(message.param1 > 0.5, message.param2 == _FORCE_MAGIC)
        if message.command == mavlink.MAV_CMD_RUN_PREARM_CHECKS:
            if not brain.armed:
                brain.check_arming()
            return TEMPORARILY_REJECTED if brain.armed else ACCEPTED
        if message.command == mavlink.MAV_CMD_NAV_TAKEOFF:
            return brain.request_take_off(message.param7)
        if message.command == mavlink.MAV_CMD_NAV_LAND:
            return brain.request_land()
        return UNSUPPORTED

    def _stumbles(self, message: Any) -> bool:
        """Whether ArduPilot before 4.5 would make integers of what is none, which aborts it in simulation."""
        if self._brain.vendor == mavlink.MAV_AUTOPILOT_PX4:
            return False
        return math.isnan(message.param5) or math.isnan(message.param6)

    def _too_fast(self, interval_us: float) -> bool:
        """Whether ArduPilot's main loop cannot send so often."""
        if self._brain.vendor == mavlink.MAV_AUTOPILOT_PX4 or interval_us <= 0.0:
            return False
        return 1e6 / interval_us > _SHARE_OF_LOOP * self._brain.parameters["SCHED_LOOP_RATE"]

    def _tell(self, identifier: int) -> int:
        """REQUEST_MESSAGE; of its origin, and of PX4's estimator, only."""
        if identifier == mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS and self._brain.vendor == mavlink.MAV_AUTOPILOT_PX4:
            self._send(estimator_status(self._clock(), self._brain.landed, self._estimator.navigates))
            return ACCEPTED
        if identifier != mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN:
            return UNSUPPORTED
        if self._origin_message is None:
            return FAILED
        self._send(self._origin_message)
        return ACCEPTED

    def _parameter_read(self, message: Any) -> None:
        parameters = self._brain.parameters
        if message.param_index >= 0:
            names = parameters.names[message.param_index : message.param_index + 1]
        else:
            names = [message.param_id] if message.param_id in parameters else []
        for name in names:
            self._send_parameter(name)

    def _parameter_list(self, message: Any) -> None:
        for name in self._brain.parameters.names:
            self._send_parameter(name)

    def _parameter_set(self, message: Any) -> None:
        if self._brain.parameters.from_wire(message.param_id, message.param_value, message.param_type):
            self._send_parameter(message.param_id)

    def _send_parameter(self, name: str) -> None:
        parameters = self._brain.parameters
        value, kind = parameters.to_wire(name)
        index = parameters.names.index(name)
        self._send(mavlink.MAVLink_param_value_message(name.encode(), value, kind, len(parameters), index))

    def _timesync(self, message: Any) -> None:
        now_ns = round(self._clock() * 1e9)
        if message.tc1 == 0:
            self._send(mavlink.MAVLink_timesync_message(now_ns, message.ts1))
        else:
            self.companion_clock.answer(message.ts1, message.tc1, now_ns)

    def _attitude_target(self, message: Any) -> None:
        self._note_setpoint()
        quaternion = np.array(message.q) * FLIP_QUATERNION
        self._brain.attitude_target(AttitudeTarget(message.type_mask, quaternion, message.thrust))

    def _position_target(self, message: Any) -> None:
        self._note_setpoint()
        self._brain.position_target(
            PositionTarget(
                message.type_mask,
                message.coordinate_frame,
                np.array([message.x, message.y, message.z]) * FLIP,
                np.array([message.vx, message.vy, message.vz]) * FLIP,
                np.array([message.afx, message.afy, message.afz]) * FLIP,
                -message.yaw,
            )
        )

    def _note_setpoint(self) -> None:
        self.setpoint_times.append(time.monotonic())
        del self.setpoint_times[:-5000]

    def _vision(self, message: Any) -> None:
        values = [message.x, message.y, message.z, message.roll, message.pitch, message.yaw]
        if not all(math.isfinite(value) for value in values):
            return
        if self._brain.vendor != mavlink.MAV_AUTOPILOT_PX4 and self._brain.parameters["VISO_QUAL_MIN"] > 0:
            return  # ArduPilot takes these poses for ones of quality 0
        now = self._clock()
        stamp = self.companion_clock.stamp(message.usec, now)
        if self._brain.vendor != mavlink.MAV_AUTOPILOT_PX4:
            stamp -= 1e-3 * self._brain.parameters["VISO_DELAY_MS"]
        since = now - stamp
        self._estimator.pose(self._uptime(), self._uptime() - since, np.array(values[:3]) * FLIP)

    def forget_origin(self) -> None:
        """Have none to tell of any more."""
        self._origin_message = None

    def _origin(self, message: Any) -> None:
        if not self._estimator.has_origin or self._brain.vendor == mavlink.MAV_AUTOPILOT_PX4:
            self._estimator.set_origin(self._uptime(), self._brain.armed, 1e-3 * message.altitude)
            self._origin_message = mavlink.MAVLink_gps_global_origin_message(
                message.latitude, message.longitude, message.altitude
            )
            self._send(self._origin_message)

    def _data_stream(self, message: Any) -> None:
        """The older way; only ArduPilot still listens to it, and only for messages of old."""
        if self._brain.vendor == mavlink.MAV_AUTOPILOT_PX4 or not message.start_stop:
            return
        rate = max(1, message.req_message_rate)
        streams = {
            mavlink.MAV_DATA_STREAM_EXTRA1: mavlink.MAVLINK_MSG_ID_ATTITUDE,
            mavlink.MAV_DATA_STREAM_POSITION: mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
            mavlink.MAV_DATA_STREAM_EXTENDED_STATUS: mavlink.MAVLINK_MSG_ID_SYS_STATUS,
        }
        if message.req_stream_id in streams:
            self._schedule.set_interval(streams[message.req_stream_id], 1e6 / rate)
