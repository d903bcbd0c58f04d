"""The thread that owns the bus: cycles at their own rate, reconnects, recovers, and always ends at zero velocity."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from doorman.background import InThread
from doorman.exceptions import BackendError
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.cycle import ServoCommand, ServoCycle
from doorman.hardware.dynamixel.faults import ServoEvent, ServoFault
from doorman.hardware.dynamixel.sample import BusState, ServoSample
from doorman.hardware.dynamixel.setup.recovery import recover
from doorman.hardware.dynamixel.setup.talk import Servo
from doorman.hardware.dynamixel.wire.connection import Connection
from doorman.hardware.dynamixel.wire.port import PortLost
from doorman.hardware.events import EventLog

RECONNECT_INTERVAL = 0.1
"""How often an unplugged device is looked for [s]."""
STARTS_KEPT = 4000


@dataclass
class RecoveryRequest:
    """Somebody waits for a recovery."""

    deadline: float
    done: threading.Event
    failures: list[str] = field(default_factory=lambda: ["the bus was stopped meanwhile"])


@dataclass(frozen=True)
class BusStatistics:
    """How the cycles ran; periods are those of the last few thousand."""

    cycles: int
    overruns: int
    """Cycles that began late, since the one before took longer than a period."""
    period_median: float
    """[s]."""
    period_p999: float
    """[s]."""
    period_max: float
    """[s]."""


class BusWorker(InThread):
    """Runs cycles until it is stopped."""

    _patience = 3.0

    def __init__(
        self,
        connection: Connection,
        cycle: ServoCycle,
        config: ServoConfig,
        log: EventLog[ServoEvent],
        first: ServoSample,
    ) -> None:
        super().__init__("servo-bus", connection.clock)
        self._connection: Connection | None = connection
        self._cycle = cycle
        self._config = config
        self._log = log
        self._published = self._clock.condition()
        self._starts: deque[float] = deque(maxlen=STARTS_KEPT)
        self._next = 0.0
        self._overruns = 0
        self.command: ServoCommand | None = None  # newest command; replaced as a whole, so no lock is needed
        self.request: RecoveryRequest | None = None  # recovery that is asked for
        self.latest = first  # newest sample; replaced as a whole

    def _begin(self) -> None:
        self._next = self._clock.now()

    def _stuck(self) -> None:
        raise BackendError("the servo bus does not stop", field="servos.port", given=self._config.port,
                           allowed="a device that answers; the servos' watchdogs stop the arm")  # fmt: skip

    def wait(self, cycle: int, timeout: float) -> ServoSample:
        """Wait for a sample after a cycle."""
        with self._published:
            if not self._published.wait_for(lambda: self.latest.cycle > cycle, timeout):
                raise BackendError("no new sample of the servos", field="servos", given=f"after {timeout:g} s")
            return self.latest

    def statistics(self) -> BusStatistics:
        starts = np.array(tuple(self._starts))
        periods = np.diff(starts) if len(starts) > 1 else np.array([self._config.period])
        median, high = np.percentile(periods, [50.0, 99.9])
        return BusStatistics(self._cycle.count, self._overruns, float(median), float(high), float(periods.max()))

    def _run(self) -> None:
        try:
            while not self._stopping.is_set():
                self._pace()
                self._guarded(self._turn)
        finally:
            self._guarded(self._finish)
            self._publish(replace(self.latest, state=BusState.STOPPED))
            if self.request is not None:
                self.request.done.set()

    def _pace(self) -> None:
        """Wait for the next cycle; one that is late is not made up for."""
        self._next += self._config.period
        now = self._clock.now()
        if now < self._next:
            self._clock.sleep(self._next - now)
        elif now > self._next + self._config.period:
            self._overruns += 1
            self._next = now

    def _guarded(self, action: Callable[[], None]) -> None:
        """Whatever fails in an action becomes a fault and a stop; the thread lives on."""
        try:
            try:
                action()
            except PortLost:
                raise
            except Exception as error:  # the last line of defence: without the thread, nobody commands zero velocity
                self._cycle.bus_fault |= ServoFault.INTERNAL
                text = f"internal failure: {type(error).__name__}: {error}"
                self._log.write(ServoEvent(self._clock.now(), None, ServoFault.INTERNAL, True, text))
                self._publish(replace(self.latest, bus_fault=self._cycle.bus_fault, state=BusState.HOLDING))
                if self._connection is not None:
                    self._cycle.halt()
        except PortLost as error:
            self._disconnect(str(error))

    def _turn(self) -> None:
        if self._connection is None:
            self._reconnect()
        else:
            self._cycle_once()
        if self.request is not None:
            request, self.request = self.request, None
            self._recover(request)

    def _cycle_once(self) -> None:
        self._starts.append(self._clock.now())
        self._publish(self._cycle.step(self.command))

    def _recover(self, request: RecoveryRequest) -> None:
        connection = self._connection
        request.failures = ["the serial device is gone"]
        try:
            if connection is not None:
                request.failures = recover(
                    self._cycle, connection.quick, self._config, self._log, request.deadline, self._breathe
                )
        finally:
            request.done.set()

    def _breathe(self) -> None:
        """Run a cycle if one is due, in the middle of something longer."""
        if self._stopping.is_set():
            raise BackendError("the bus is being stopped", field="servos")
        if self._clock.now() >= self._next + self._config.period:
            self._next = self._clock.now()
            self._cycle_once()

    def _publish(self, sample: ServoSample) -> None:
        with self._published:
            self.latest = sample
            self._published.notify_all()

    def _disconnect(self, why: str) -> None:
        if self._connection is not None:
            self._connection.port.close()
            self._connection = None
        self._cycle.bus_fault |= ServoFault.UNPLUGGED
        self._log.write(ServoEvent(self._clock.now(), None, ServoFault.UNPLUGGED, True, why))
        self._cycle.count += 1
        self._publish(self._cycle.sample(BusState.DISCONNECTED))

    def _reconnect(self) -> None:
        """Open the device again and check who answers; what the servos went through shows in the next cycle."""
        self._stopping.wait(RECONNECT_INTERVAL)
        self._next = self._clock.now()
        if not self._config.reconnect or self._stopping.is_set():
            return
        connection = None
        try:
            connection = Connection.open(self._config, self._clock)
            deadline = self._clock.now() + self._config.open_timeout
            for servo_id, known in zip(self._config.ids, self._cycle.ready, strict=True):
                Servo(connection.quick, servo_id, deadline).identify((known.model,))
        except BackendError:  # not there yet, or not whole: tried again
            if connection is not None:
                connection.port.close()
            return
        self._connection = connection
        self._cycle.use(connection.quick)
        self._cycle.bus_fault &= ~ServoFault.UNPLUGGED
        self._log.write(ServoEvent(self._clock.now(), None, ServoFault.UNPLUGGED, False, "serial device opened again"))

    def _finish(self) -> None:
        """Zero velocity, then rest; if that fails, the servos' own watchdogs stop them."""
        connection = self._connection
        if connection is None:
            return
        try:
            self._cycle.halt()
            for failure in connection.rest(self._config):
                text = f"the servo did not take zero velocity, its watchdog stops it: {failure}"
                self._log.write(ServoEvent(self._clock.now(), None, ServoFault.NONE, True, text))
        finally:
            connection.port.close()
