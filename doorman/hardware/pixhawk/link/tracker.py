"""Telemetry messages into the newest sample; what is old, doubled, out of order or not a number is left out and counted."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from doorman.arrays import frozen, sealed
from doorman.hardware.pixhawk.config import HEARTBEAT, Timeouts
from doorman.hardware.pixhawk.dialect import Dialect
from doorman.hardware.pixhawk.link.timesync import ClockMap
from doorman.hardware.pixhawk.sample import LARGEST, Battery, LandedState, VehicleSample, unknown
from doorman.hardware.pixhawk.wire.frames import LocalFrame, frd_to_flu
from doorman.hardware.pixhawk.wire.messages import Message, boot_ms_difference, cells_to_volts, figure, mavlink
from doorman.kinematics.quaternions import to_attitude

_REORDER_SPAN = 64
_STAMPS_ANEW = 5
"""Messages of a kind in a row, in order among themselves but behind the newest, after which that one was wrong."""
_LOW_CHARGE_STATES = frozenset({2, 3, 4, 5, 6})
"""MAV_BATTERY_CHARGE_STATE low, critical, emergency, failed, unhealthy."""
_LOCATED = mavlink.ESTIMATOR_POS_HORIZ_REL | mavlink.ESTIMATOR_POS_HORIZ_ABS | mavlink.ESTIMATOR_VELOCITY_HORIZ
_DOUBTS = 5
"""Words of the estimator in a row, 0.2 s apart, after which its position is not used."""
_PREARM_BIT = mavlink.MAV_SYS_STATUS_PREARM_CHECK


@dataclass
class TelemetryCounters:
    disordered: int = 0  # duplicates and messages overtaken by newer ones
    invalid: int = 0  # not finite, out of all bounds, or not a unit quaternion


class Tracker:
    def __init__(self, clock: ClockMap, local_frame: LocalFrame, timeouts: Timeouts = Timeouts()) -> None:
        self.counters = TelemetryCounters()
        self._clock = clock
        self._frame = local_frame
        self._stale = timeouts.state  # a stamp that lies so far in the future is wrong [s]
        self._battery_silent = timeouts.battery / 2
        """Silence of the first battery after which another one counts, or what SYS_STATUS says of all of them [s]."""
        self._unsaid_until = -math.inf
        self.reset()

    def reset(self) -> None:
        self.sample = VehicleSample()
        self._stamps: dict[str, int] = {}
        self._behind: dict[str, tuple[int, int]] = {}
        self._last_sequence: tuple[int, float] | None = None
        self._doubts = 0
        self._battery_id, self._battery_time, self._cells = math.inf, -math.inf, False

    def in_order(self, sequence: int, now: float) -> bool:
        """Whether a message is neither a copy of the last one nor overtaken by it."""
        if self._last_sequence is not None:
            last, heard = self._last_sequence
            step = (sequence - last) % 256
            if now - heard < self._stale / 2 and (step == 0 or step > 256 - _REORDER_SPAN):
                self.counters.disordered += 1
                return False
        self._last_sequence = (sequence, now)
        return True

    def take(self, message: Message, now: float) -> None:
        TELEMETRY[message.get_type()](self, message, now)

    def heartbeat(self, message: Message, dialect: Dialect, now: float) -> None:
        self.sample = replace(
            self.sample,
            mode=dialect.mode(message.custom_mode),
            armed=bool(message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED),
            system_status=int(message.system_status),
            heartbeat_time=now,
        )

    def estimator(self, flags: int) -> None:
        """Take in how the autopilot says that its estimator is: positions that it does not believe itself are not used."""
        self._doubts, self._unsaid_until = 0 if flags & _LOCATED else self._doubts + 1, -math.inf

    def expect_estimator(self, now: float) -> None:
        """Believe no position before the autopilot has said that it does itself, for a while."""
        self._doubts, self._unsaid_until = _DOUBTS - 1, now + 2 * HEARTBEAT  # its rate is asked for twice meanwhile

    def _when(self, message: Message, now: float) -> float | None:
        """When a message was true [s]; None if it is not newer than the last of its kind, or from the future."""
        kind, stamp = message.get_type(), int(message.time_boot_ms)
        if self._clock.ahead(1e-3 * stamp, now) > self._stale:
            self.counters.invalid += 1
            return None
        last = self._stamps.get(kind)
        if last is not None and boot_ms_difference(stamp, last) <= 0:
            self.counters.disordered += 1
            count, previous = self._behind.get(kind, (0, stamp - 1))
            count = count + 1 if boot_ms_difference(stamp, previous) > 0 else 1
            self._behind[kind] = (count, stamp)
            if count < _STAMPS_ANEW:
                return None
        self._behind.pop(kind, None)
        self._stamps[kind] = stamp
        return self._clock.to_local(1e-3 * stamp, now)

    def _plausible(self, values: list[float], possible: bool = True) -> bool:
        if possible and all(abs(value) <= LARGEST for value in values):
            return True
        self.counters.invalid += 1
        return False

    def _attitude(self, message: Message, now: float) -> None:
        raw = [message.q1, message.q2, message.q3, message.q4]
        rates = [message.rollspeed, message.pitchspeed, message.yawspeed]
        norm = math.hypot(*raw)
        if not self._plausible([*raw, *rates], abs(norm - 1.0) <= 0.05) or (when := self._when(message, now)) is None:
            return
        quaternion = self._frame.quaternion_to_world([value / norm for value in raw])
        self.sample = replace(
            self.sample,
            attitude_time=when,
            quaternion=sealed(quaternion),
            attitude=frozen(to_attitude(quaternion.tolist())),
            body_rates=sealed(frd_to_flu(rates)),
        )

    def _position(self, message: Message, now: float) -> None:
        position, velocity = [message.x, message.y, message.z], [message.vx, message.vy, message.vz]
        if not self._plausible(position + velocity) or (when := self._when(message, now)) is None:
            return
        if self._doubts >= _DOUBTS or now < self._unsaid_until:
            return
        self.sample = replace(
            self.sample,
            position_time=when,
            position=sealed(self._frame.position_to_world(position)),
            velocity=sealed(self._frame.vector_to_world(velocity)),
        )

    def _system(self, message: Message, now: float) -> None:
        battery = self.sample.battery
        if now - self._battery_time > self._battery_silent:
            battery = replace(
                battery,
                voltage=figure(message.voltage_battery, 1e-3),
                current=figure(message.current_battery, 1e-2),
                remaining=figure(message.battery_remaining, 1e-2),
                time=now,
                id=None,
            )
        elif not self._cells:
            battery = replace(battery, voltage=figure(message.voltage_battery, 1e-3))
        enabled = bool(message.onboard_control_sensors_enabled & _PREARM_BIT)
        ready = bool(message.onboard_control_sensors_health & _PREARM_BIT) if enabled else None
        self.sample = replace(self.sample, battery=battery, ready_to_arm=ready)

    def _battery(self, message: Message, now: float) -> None:
        if message.id > self._battery_id and now - self._battery_time < self._battery_silent:
            return  # the first battery flies the vehicle, whatever its number
        voltage, remaining = (
            cells_to_volts([*message.voltages, *filter(None, message.voltages_ext)]),
            figure(message.battery_remaining, 1e-2),
        )
        if math.isnan(voltage) and math.isnan(remaining):
            return  # a socket that nothing is plugged into
        self._battery_id, self._battery_time = message.id, now
        self._cells = not math.isnan(voltage)
        battery = Battery(
            voltage=voltage if self._cells else self.sample.battery.voltage,
            current=figure(message.current_battery, 1e-2),
            remaining=remaining,
            alarm=message.charge_state in _LOW_CHARGE_STATES,
            time=now,
            id=int(message.id),
        )
        self.sample = replace(self.sample, battery=battery)

    def _extended(self, message: Message, now: float) -> None:
        known = {state.value: state for state in LandedState}
        self.sample = replace(self.sample, landed=known.get(message.landed_state, LandedState.UNKNOWN))

    def _attitude_target(self, message: Message, now: float) -> None:
        if not self._plausible([message.thrust]) or not 0.0 <= message.thrust <= 1.0:
            return
        if (when := self._when(message, now)) is None:
            return
        norm, target = math.hypot(*message.q), unknown(3)
        if 0.9 < norm < 1.1:
            quaternion = self._frame.quaternion_to_world([value / norm for value in message.q])
            target = frozen(to_attitude(quaternion.tolist()))
        self.sample = replace(
            self.sample, thrust_target=float(message.thrust), thrust_target_time=when, attitude_target=target
        )


TELEMETRY: Mapping[str, Callable[[Tracker, Message, float], None]] = {
    "ATTITUDE_QUATERNION": Tracker._attitude,
    "LOCAL_POSITION_NED": Tracker._position,
    "SYS_STATUS": Tracker._system,
    "BATTERY_STATUS": Tracker._battery,
    "EXTENDED_SYS_STATE": Tracker._extended,
    "ATTITUDE_TARGET": Tracker._attitude_target,
}
"""What takes in a message, by its name."""
