r"""From answers to faults: what one servo's replies say about its health.

Proof of freshness by the servo's own clock: is an answer younger than the question?

Protocol 2.0 numbers nothing, so a late, repeated or frozen answer looks like the one that is awaited. Every answer carries the
servo's millisecond clock c. With h the computer's clock, the measurement lies between question and answer, so

.. math::
    c - h_\mathrm{received} \le o \le c - h_\mathrm{sent}

holds for the offset o of the clocks whenever the answer belongs to the question. The largest lower bound so far is kept; an
answer whose upper bound lies below it was measured before the question was sent. Answers that are too old only weaken their own
bound, so they cannot spoil it.
"""

from __future__ import annotations

import math

from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.faults import LATCHED, ServoFault
from doorman.hardware.dynamixel.link import Reply
from doorman.hardware.dynamixel.registers import TICK_RANGE, HardwareError, Telemetry, Unit

RESOLUTION = 2 * Unit.CLOCK
"""Two readings of a clock of whole milliseconds [s]."""
DRIFT = 1e-2
"""Largest drift between the clocks: what a clock without a quartz may be off. An answer that comes late by d from some moment on
is reported for about d / DRIFT, far longer than it takes to stop the arm."""


class ServoClock:
    """Bounds of the offset between a servo's clock and the computer's."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forget the offset, as after a restart of the servo."""
        self._tick: int | None = None
        self._clock = 0.0
        self._heard = 0.0
        self._bound = -math.inf
        self.runs = False  # whether the servo's clock was seen to advance; only then it proves anything

    def lateness(self, sent: float, received: float, tick: int) -> float:
        """Least time by which an answer is older than its question [s]."""
        clock = self._unwrap(received, tick)
        self._bound -= DRIFT * (received - self._heard)
        late = self._bound - (clock - sent) - RESOLUTION
        self._bound = max(self._bound, clock - received)
        self._heard = received
        return max(late, 0.0) if self.runs else 0.0

    def _unwrap(self, received: float, tick: int) -> float:
        """The servo's clock without the jumps to zero [s]: counted on from the last answer."""
        if self._tick is None:
            self._tick, self._heard = tick, received
        step = (tick - self._tick + TICK_RANGE // 2) % TICK_RANGE - TICK_RANGE // 2
        rounds = round((received - self._heard - step * Unit.CLOCK) / (TICK_RANGE * Unit.CLOCK))
        self.runs = self.runs or step != 0
        self._tick = tick
        self._clock += (step + rounds * TICK_RANGE) * Unit.CLOCK
        return self._clock


HYSTERESIS = 5.0
"""Hysteresis of a hot servo's temperature [°C]."""
PLAY = math.radians(1.0)
"""Largest jump of an angle by play and noise, four times the maker's figure [rad]."""
_ANGLE_LIES = ServoFault.ENCODER | ServoFault.JUMPED


class ServoMonitor:
    def __init__(self, config: ServoConfig, now: float, model: int, joint: int) -> None:
        self._config = config
        self._fastest = float(config.limits.rates[joint])
        self._before: Telemetry | None = None  # from whose angle the next one goes on; None before any
        self._jumped_to: int | None = None  # where the last answer had jumped to [tick]
        self._current_unit = Unit.CURRENT[model]
        self.clock = ServoClock()
        self.telemetry: Telemetry | None = None  # newest that is fresh and believed
        self.time = now  # when it was measured [s]
        self.fault = ServoFault.NONE  # what is wrong now
        self.latched = ServoFault.NONE  # what two answers in a row have reported, until it is set up again
        self._suspected = ServoFault.NONE
        self._strained_since: float | None = None

    def take(self, reply: Reply) -> Telemetry | None:
        fault = reply.fault
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
            if (fault | self.latched) & _ANGLE_LIES:  # what it tells of itself is so, but for its angle
                telemetry = None
        if telemetry is not None:
            self.telemetry = self._before = telemetry
            self.time = reply.sent
        elif reply.received - self.time > self._config.stale_after:
            missing = reply.received - self.time > self._config.missing_after
            fault |= ServoFault.STALE | ServoFault.MISSING if missing else ServoFault.STALE
        self.fault = fault | self.latched
        return telemetry

    def recovered(self) -> None:
        """Forget latched faults: the servo was set up again. What was measured before is as old as it is."""
        self.latched = self._suspected = self.fault = ServoFault.NONE
        self._strained_since = self._before = self._jumped_to = None
        self.clock.restart()

    def condemn(self, fault: ServoFault) -> None:
        """Latch a fault that was found in another way than by telemetry."""
        self.latched |= fault
        self.fault |= fault

    def _latch(self, fault: ServoFault) -> ServoFault:
        """Latch what two answers in a row say: one damaged answer in 65536 has the right CRC."""
        self.latched |= fault & self._suspected
        self._suspected = fault
        return fault

    def _health(self, telemetry: Telemetry, now: float) -> ServoFault:
        fault = ServoFault.NONE
        for bit in HardwareError(telemetry.hardware_error):
            fault |= ServoFault[str(bit.name)]
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
        reported = Unit.VELOCITY * max(abs(telemetry.velocity), abs(before.velocity))
        most = PLAY + max(self._fastest, reported) * (now - self.time) + reported * self._config.latency
        ticks = abs(telemetry.position - before.position)
        jumps = ticks * Unit.ANGLE > most
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
