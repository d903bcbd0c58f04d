"""What the emulated autopilot tells: messages with their stamps, and when which of them is due."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.clocks import BRIEFLY
from doorman.rig.emulators.autopilot.brain import Brain
from doorman.rig.emulators.autopilot.control import Task
from doorman.rig.emulators.autopilot.dialects import Build
from doorman.rig.emulators.autopilot.estimator import FLIP, FLIP_QUATERNION, Estimator
from doorman.rig.emulators.autopilot.line import BootClock

_READY = mavlink.MAV_SYS_STATUS_PREARM_CHECK
_EPOCH_2015 = 1_420_070_400
"""Zero of the time stamps of signatures [s]."""


@dataclass
class EmulatedBattery:
    """What the power module measures; set it at any time."""

    voltage: float = 15.6  # [V]
    current: float = 12.0  # [A]
    remaining: float = 0.9  # 0 … 1
    silent: bool = False  # whether it is not measured


class Telemetry:
    def __init__(
        self,
        brain: Brain,
        estimator: Estimator,
        battery: EmulatedBattery,
        clock: BootClock,
        build: Build,
        transmit: Callable[[bytes], None],
    ) -> None:
        self.heartbeats_stopped = self.confused = False
        """Whether heartbeats are left out, and whether its state is not numbers; may be set at any time."""
        self.steered, self.normalised = estimator.estimate.quaternion, 0.0
        """Attitude by which the controller steers, shape (4,), and thrust that it asks of the mixer, 0 … 1."""
        rates = {**build.dialect.rates, mavlink.MAVLINK_MSG_ID_HEARTBEAT: build.heartbeat_rate}
        self._periods = {identifier: 1.0 / rate for identifier, rate in rates.items()}
        self._next: dict[int, float] = {}  # when which message is due
        self.mav = mavlink.MAVLink(None, build.system_id, mavlink.MAV_COMP_ID_AUTOPILOT1)  # reads and writes messages
        self.mav.robust_parsing = True
        if build.signing_key is not None:
            self.mav.signing.secret_key, self.mav.signing.sign_outgoing = build.signing_key, True
            self.mav.signing.timestamp = int((time.time() - _EPOCH_2015) * 1e5)
        self._brain, self._estimator, self._battery, self._clock = brain, estimator, battery, clock
        self._type, self._transmit, self._px4 = build.vehicle_type, transmit, brain.dialect.heeds_stream

    def speak(self) -> None:
        now = self._clock.uptime
        for identifier, period in self._periods.items():
            at = self._next.get(identifier, now)
            if now < at:
                continue
            self._next[identifier] = at + period if now - at < 3.0 * period else now + period
            if identifier != mavlink.MAVLINK_MSG_ID_HEARTBEAT or not self.heartbeats_stopped:
                self._send_if_any(identifier, self._estimator.estimate.position_valid)
        for severity, text in self._brain.texts:
            self.send(mavlink.MAVLink_statustext_message(severity, text.encode()[:50]))
        self._brain.texts.clear()

    def set_interval(self, identifier: int, interval_us: float) -> bool:
        if identifier not in self._brain.dialect.on_request:
            return False
        self._periods.pop(identifier, None)
        if interval_us > 0.0:
            self._periods[identifier] = max(interval_us * 1e-6, 2 * BRIEFLY)
        return True

    def tell(self, identifier: int) -> bool:
        known = identifier in self._brain.dialect.on_request
        return known and self._send_if_any(identifier, self._estimator.navigates)

    def send(self, message: Any) -> None:
        data = message.pack(self.mav)
        self.mav.seq = (self.mav.seq + 1) % 256
        self._transmit(data)

    def _send_if_any(self, identifier: int, located: bool) -> bool:
        message = self._message(identifier, located)
        if message is not None:
            self.send(message)
        return message is not None

    def _message(self, identifier: int, located: bool) -> Any | None:
        """The message of an identifier; None if there is none to send."""
        seconds, estimate = self._clock.now, self._estimator.estimate
        boot_ms, sense = int(seconds * 1e3) % (1 << 32), math.nan if self.confused else 1.0
        match identifier:
            case mavlink.MAVLINK_MSG_ID_HEARTBEAT:
                return self._heartbeat()
            case mavlink.MAVLINK_MSG_ID_TIMESYNC:
                return mavlink.MAVLink_timesync_message(0, round(seconds * 1e9))
            case mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION:
                q, rates = estimate.quaternion * FLIP_QUATERNION * sense, estimate.body_rates * FLIP
                return mavlink.MAVLink_attitude_quaternion_message(boot_ms, *q.tolist(), *rates.tolist())
            case mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED if estimate.position_valid or self._px4:
                place, speed = estimate.position * FLIP * sense, estimate.velocity * FLIP
                return mavlink.MAVLink_local_position_ned_message(boot_ms, *place.tolist(), *speed.tolist())
            case mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET:
                q = (self.steered * FLIP_QUATERNION).tolist()
                return mavlink.MAVLink_attitude_target_message(boot_ms, 0, q, 0.0, 0.0, 0.0, self.normalised)
            case mavlink.MAVLINK_MSG_ID_SYS_STATUS:
                return self._system()
            case mavlink.MAVLINK_MSG_ID_BATTERY_STATUS if not self._battery.silent:
                return self._battery_status()
            case mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE:
                return mavlink.MAVLink_extended_sys_state_message(0, self._landed_state())
            case mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS:
                flags = mavlink.ESTIMATOR_POS_HORIZ_REL if located else mavlink.ESTIMATOR_CONST_POS_MODE
                flags |= mavlink.ESTIMATOR_ATTITUDE | mavlink.ESTIMATOR_CONST_POS_MODE * self._brain.landed
                return mavlink.MAVLink_estimator_status_message(round(seconds * 1e6), flags, *[0.0] * 8)
            case mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN if self._estimator.origin is not None:
                return mavlink.MAVLink_gps_global_origin_message(*self._estimator.origin)
        return None

    def _heartbeat(self) -> Any:
        brain = self._brain
        base = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | mavlink.MAV_MODE_FLAG_SAFETY_ARMED * brain.armed
        status = mavlink.MAV_STATE_STANDBY
        if brain.armed:
            status = mavlink.MAV_STATE_CRITICAL if brain.failsafe else mavlink.MAV_STATE_ACTIVE
            if brain.killed and self._px4:  # ArduPilot's says nothing
                status = mavlink.MAV_STATE_FLIGHT_TERMINATION
        return mavlink.MAVLink_heartbeat_message(self._type, brain.dialect.vendor, base, brain.mode, status, 3)

    def _system(self) -> Any:
        """SYS_STATUS: whether it would arm PX4 tells in its health alone."""
        health = _READY if self._estimator.estimate.position_valid and self._brain.refusal is None else 0
        present, battery = 0 if self._px4 else _READY, self._battery
        power = round(battery.voltage * 1e3), round(battery.current * 1e2), round(battery.remaining * 1e2)
        known = (0xFFFF, -1, -1) if battery.silent else power
        return mavlink.MAVLink_sys_status_message(present, present, health, 200, *known, 0, 0, 0, 0, 0, 0)

    def _battery_status(self) -> Any:
        battery = self._battery
        state = 3 if battery.remaining < 0.07 else 2 if battery.remaining < 0.15 else 1
        cells, current = [round(battery.voltage / 4.0 * 1e3)] * 4 + [0xFFFF] * 6, round(battery.current * 1e2)
        left = round(battery.remaining * 1e2)
        return mavlink.MAVLink_battery_status_message(0, 0, 1, 32767, cells, current, -1, -1, left, 0, state)

    def _landed_state(self) -> int:
        if self._brain.landed:
            return int(mavlink.MAV_LANDED_STATE_ON_GROUND)
        landing = self._brain.demand.task is Task.LAND
        return int(mavlink.MAV_LANDED_STATE_LANDING if landing else mavlink.MAV_LANDED_STATE_IN_AIR)
