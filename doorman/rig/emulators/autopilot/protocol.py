"""What the emulated autopilot does with messages that it receives: commands, parameters, clock, setpoints and poses."""

from __future__ import annotations

import math
import struct
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot.brain import AttitudeTarget, Brain, PositionTarget
from doorman.rig.emulators.autopilot.commands import Command, Commands
from doorman.rig.emulators.autopilot.earth import Place, global_origin
from doorman.rig.emulators.autopilot.estimator import Estimator
from doorman.rig.emulators.autopilot.plant import Array
from doorman.rig.emulators.autopilot.schedule import Schedule
from doorman.rig.emulators.autopilot.telemetry import FLIP, FLIP_QUATERNION

_STREAMS = {
    mavlink.MAV_DATA_STREAM_EXTENDED_STATUS: (mavlink.MAVLINK_MSG_ID_SYS_STATUS, mavlink.MAVLINK_MSG_ID_GPS_RAW_INT),
    mavlink.MAV_DATA_STREAM_POSITION: (
        mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
        mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
    ),
    mavlink.MAV_DATA_STREAM_EXTRA1: (mavlink.MAVLINK_MSG_ID_ATTITUDE,),
    mavlink.MAV_DATA_STREAM_EXTRA3: (mavlink.MAVLINK_MSG_ID_BATTERY_STATUS,),
}
"""Messages of ArduPilot's streams."""
_VISUAL = (
    mavlink.MAV_ESTIMATOR_TYPE_UNKNOWN,
    mavlink.MAV_ESTIMATOR_TYPE_NAIVE,
    mavlink.MAV_ESTIMATOR_TYPE_VISION,
    mavlink.MAV_ESTIMATOR_TYPE_VIO,
)
"""Of ODOMETRY, what PX4 fuses."""


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
        tell: Sends the message of an identifier; False if there is none.
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
        tell: Callable[[int], bool],
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
        self.commands = Commands(brain, estimator, schedule, tell)
        self._px4 = brain.vendor == mavlink.MAV_AUTOPILOT_PX4
        self.companion_clock = ClockOfOthers(self._px4)
        self._brain = brain
        self._estimator = estimator
        self._schedule = schedule
        self._send = send
        self._clock, self._uptime = clock, uptime
        self._system = system_id
        self._handlers: dict[str, Callable[[Any], None]] = {
            "HEARTBEAT": self._heartbeat,
            "COMMAND_LONG": self._command,
            "COMMAND_INT": self._command,
            "SET_MODE": self._mode,
            "PARAM_REQUEST_READ": self._parameter_read,
            "PARAM_REQUEST_LIST": self._parameter_list,
            "PARAM_SET": self._parameter_set,
            "TIMESYNC": self._timesync,
            "SET_ATTITUDE_TARGET": self._attitude_target,
            "SET_POSITION_TARGET_LOCAL_NED": self._position_target,
            "VISION_POSITION_ESTIMATE": self._vision,
            "ODOMETRY": self._odometry,
            "SET_GPS_GLOBAL_ORIGIN": self._origin,
            "REQUEST_DATA_STREAM": self._data_stream,
            "MISSION_REQUEST_LIST": self._missions,
        }

    def take(self, message: Any) -> None:
        """Act on a message; those to other systems are not for us, nor for PX4 those to other components."""
        if getattr(message, "target_system", 0) not in (0, self._system):
            return
        if self._px4 and getattr(message, "target_component", 0) not in (0, mavlink.MAV_COMP_ID_AUTOPILOT1):
            return
        self.received[message.get_type()] += 1
        handler = self._handlers.get(message.get_type())
        if handler is not None:
            handler(message)

    def _heartbeat(self, message: Any) -> None:
        self.heartbeat_types.add((message.get_srcSystem(), message.get_srcComponent(), message.type))
        if self._px4:
            from_station = message.type == mavlink.MAV_TYPE_GCS
        else:
            from_station = message.get_srcSystem() == int(self._brain.parameters["SYSID_MYGCS"])
        if from_station:
            self.station_heard = self._uptime()

    def _command(self, message: Any) -> None:
        if self.ignore_commands > 0:
            self.ignore_commands -= 1
            return
        result = self.commands.execute(Command.of(message))
        if self.mute_commands > 0:
            self.mute_commands -= 1
            return
        self._acknowledge(message, message.command, result)

    def _mode(self, message: Any) -> None:
        """SET_MODE, the older way; PX4 makes a command of it, which it acknowledges, ArduPilot says nothing."""
        mode = message.custom_mode
        words = (mode >> 16 & 0xFF, mode >> 24) if self._px4 else (mode, 0)
        command = Command(mavlink.MAV_CMD_DO_SET_MODE, (message.base_mode, *words, 0.0, 0.0, 0.0, 0.0))
        result = self.commands.execute(command)
        if self._px4:
            self._acknowledge(message, command.number, result)

    def _acknowledge(self, message: Any, command: int, result: int) -> None:
        self._send(
            mavlink.MAVLink_command_ack_message(
                command, result, 0, 0, message.get_srcSystem(), message.get_srcComponent()
            )
        )

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
        quaternion, body = np.array(message.q) * FLIP_QUATERNION, thrust_body(message) * FLIP
        self._brain.attitude_target(AttitudeTarget(message.type_mask, quaternion, message.thrust, body))

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
        self._pose(message.usec, values, quality=0)

    def _odometry(self, message: Any) -> None:
        """ArduPilot takes one frame, PX4 the local ones that look down, and of estimators the visual ones."""
        frames = [mavlink.MAV_FRAME_LOCAL_FRD, *[mavlink.MAV_FRAME_LOCAL_NED] * self._px4]
        if message.frame_id not in frames or (self._px4 and message.estimator_type not in _VISUAL):
            return
        if not self._px4 and message.child_frame_id != mavlink.MAV_FRAME_BODY_FRD:
            return
        self._pose(message.time_usec, [message.x, message.y, message.z, *message.q], message.quality)

    def _pose(self, stamp_us: int, values: list[float], quality: int) -> None:
        """Fuse a position, NED [m], with the attitude behind it, of which the estimator needs none."""
        if not all(math.isfinite(value) for value in values):
            return
        if not self._px4 and quality < self._brain.parameters["VISO_QUAL_MIN"]:
            return
        now = self._clock()
        stamp = self.companion_clock.stamp(stamp_us, now)
        if not self._px4:
            stamp -= 1e-3 * self._brain.parameters["VISO_DELAY_MS"]
        since = now - stamp
        self._estimator.pose(self._uptime(), self._uptime() - since, np.array(values[:3]) * FLIP)

    def _origin(self, message: Any) -> None:
        if not self._estimator.has_origin or self._px4:
            place = Place(1e-7 * message.latitude, 1e-7 * message.longitude, 1e-3 * message.altitude)
            self._estimator.set_origin(self._uptime(), self._brain.armed, place)
            self._send(global_origin(place))

    def _data_stream(self, message: Any) -> None:
        """The older way; only ArduPilot still listens to it, and only for messages of old."""
        if self._px4:
            return
        rate = min(message.req_message_rate, self.commands.most_often) if message.start_stop else 0
        asked = message.req_stream_id
        for identifiers in _STREAMS.values() if asked == mavlink.MAV_DATA_STREAM_ALL else [_STREAMS.get(asked, ())]:
            for identifier in identifiers:
                self._schedule.set_interval(identifier, 1e6 / rate if rate > 0 else -1.0)

    def _missions(self, message: Any) -> None:
        """There are none."""
        self._send(
            mavlink.MAVLink_mission_count_message(
                message.get_srcSystem(), message.get_srcComponent(), 0, message.mission_type
            )
        )


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
