"""From answers to faults: what one servo's replies say about its health."""

from __future__ import annotations

import math

from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.faults import LATCHED, ServoFault
from doorman.hardware.dynamixel.servo_clock import ServoClock
from doorman.hardware.dynamixel.wire.link import Outcome, Reply
from doorman.hardware.dynamixel.wire.registers import HardwareError
from doorman.hardware.dynamixel.wire.telemetry import Telemetry
from doorman.hardware.dynamixel.wire.units import CURRENT_UNITS, RADIANS_PER_TICK, VELOCITY_UNIT

HYSTERESIS = 5.0
"""Hysteresis of a hot servo's temperature [°C]."""
PLAY = math.radians(1.0)
"""Largest jump of an angle by play and noise, four times the maker's figure [rad]."""
_ANGLE_LIES = ServoFault.ENCODER | ServoFault.JUMPED
_OUTCOMES = {
    Outcome.TIMEOUT: ServoFault.TIMEOUT,
    Outcome.CORRUPT: ServoFault.CORRUPT,
    Outcome.REFUSED: ServoFault.REFUSED,
}
_HARDWARE = {
    HardwareError.VOLTAGE: ServoFault.VOLTAGE,
    HardwareError.OVERHEATING: ServoFault.OVERHEATING,
    HardwareError.ENCODER: ServoFault.ENCODER,
    HardwareError.SHOCK: ServoFault.SHOCK,
    HardwareError.OVERLOAD: ServoFault.OVERLOAD,
}


class ServoMonitor:
    """Memory of one servo's health."""

    def __init__(self, config: ServoConfig, now: float, model: int, joint: int) -> None:
        self._config = config
        self._fastest = float(config.limits[2][joint])
        self._before: Telemetry | None = None  # from whose angle the next one goes on; None before any
        self._jumped_to: int | None = None  # where the last answer had jumped to [tick]
        self._current_unit = CURRENT_UNITS[model]
        self.clock = ServoClock()
        self.telemetry: Telemetry | None = None  # newest that is fresh and believed
        self.time = now  # when it was measured [s]
        self.fault = ServoFault.NONE  # what is wrong now
        self._latched = ServoFault.NONE
        self._suspected = ServoFault.NONE
        self._strained_since: float | None = None

    def take(self, reply: Reply) -> Telemetry | None:
        """Judge the reply of a cycle."""
        fault = _OUTCOMES.get(reply.outcome, ServoFault.NONE)
        telemetry = Telemetry.decode(reply.data) if reply.ok else None
        if telemetry is not None and not telemetry.is_ours(self._config.watchdog_counts):
            telemetry = None
            fault |= self._latch(ServoFault.RESTARTED)
        elif telemetry is not None and self.clock.lateness(reply.sent, reply.received, telemetry.tick) > 0.0:
            telemetry = None
            fault |= ServoFault.LATE
        if telemetry is None:  # what was known of it before stands
            fault |= self.fault & (ServoFault.HOT | ServoFault.WARM | ServoFault.WATCHDOG)
        else:
            fault |= self._health(telemetry, reply.sent)
            if (fault | self._latched) & _ANGLE_LIES:  # what it tells of itself is so, but for its angle
                telemetry = None
        if telemetry is not None:
            self.telemetry, self.time = telemetry, reply.sent
            self._before = telemetry
        else:
            fault |= self._lasting(reply.received)
        self.fault = fault | self._latched
        return telemetry

    @property
    def latched(self) -> ServoFault:
        """Faults that two answers in a row have reported, until the servo is set up again."""
        return self._latched

    def recovered(self) -> None:
        """Forget latched faults: the servo was set up again. What was measured before is as old as it is."""
        self._latched = self._suspected = self.fault = ServoFault.NONE
        self._strained_since = self._before = self._jumped_to = None
        self.clock.restart()

    def condemn(self, fault: ServoFault) -> None:
        """Latch a fault that was found in another way than by telemetry."""
        self._latched |= fault
        self.fault |= fault

    def _lasting(self, now: float) -> ServoFault:
        """Faults of a servo without a fresh answer."""
        age = now - self.time
        if age > self._config.missing_after:
            return ServoFault.STALE | ServoFault.MISSING
        return ServoFault.STALE if age > self._config.stale_after else ServoFault.NONE

    def _latch(self, fault: ServoFault) -> ServoFault:
        """Latch what two answers in a row say: one damaged answer in 65536 has the right CRC."""
        self._latched |= fault & self._suspected
        self._suspected = fault
        return fault

    def _health(self, telemetry: Telemetry, now: float) -> ServoFault:
        fault = ServoFault.NONE
        if telemetry.hardware_error:
            for bit, meaning in _HARDWARE.items():
                if telemetry.hardware_error & bit:
                    fault |= meaning
        if not telemetry.torque_enable:
            fault |= ServoFault.TORQUE_OFF
        if not fault & ServoFault.ENCODER and self._jumps(telemetry, now):
            fault |= ServoFault.JUMPED
        self._latch(fault & LATCHED)
        if telemetry.bus_watchdog != self._config.watchdog_counts:  # it fired, or was cleared and not set again
            fault |= ServoFault.WATCHDOG
        return fault | self._heat(telemetry.temperature) | self._strain(telemetry.current, now)

    def _jumps(self, telemetry: Telemetry, now: float) -> bool:
        """Whether the angle is farther from the last one that was believed than the servo can have turned."""
        # As time passes, it could have: an angle that is nearer to where the last one had jumped to has jumped with it.
        before, suspect = self._before, self._jumped_to
        if before is None:
            return False
        reported = VELOCITY_UNIT * max(abs(telemetry.velocity), abs(before.velocity))
        most = PLAY + max(self._fastest, reported) * (now - self.time) + reported * self._config.latency
        ticks = abs(telemetry.position - before.position)
        jumps = ticks * RADIANS_PER_TICK > most
        jumps = jumps or (suspect is not None and abs(telemetry.position - suspect) < ticks)
        self._jumped_to = telemetry.position if jumps else None
        return jumps

    def _heat(self, temperature: int) -> ServoFault:
        fault = ServoFault.NONE
        for limit, meaning in (
            (self._config.warm_temperature, ServoFault.WARM),
            (self._config.hot_temperature, ServoFault.HOT),
        ):
            if temperature >= limit - (HYSTERESIS if self.fault & meaning else 0.0):
                fault |= meaning
        return fault

    def _strain(self, current: int, now: float) -> ServoFault:
        if abs(current) * self._current_unit < self._config.strain_current:
            self._strained_since = None
            return ServoFault.NONE
        if self._strained_since is None:
            self._strained_since = now
        lasted = now - self._strained_since >= self._config.strain_time
        return ServoFault.STRAINED if lasted else ServoFault.NONE
