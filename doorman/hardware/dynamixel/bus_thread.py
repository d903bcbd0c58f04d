"""Thread that owns the servos' port: cycles at their rate, recovers servos, and opens again a device that was unplugged."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from doorman.background import EventLog, InThread
from doorman.clocks import LONGEST_WAIT, Clock
from doorman.exceptions import BackendError
from doorman.hardware.dynamixel.commissioning import Connection, ReadyServo
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.cycle import ServoCommand, ServoCycle
from doorman.hardware.dynamixel.faults import BusState, ServoEvent, ServoFault, ServoSample
from doorman.hardware.dynamixel.port import PortLost

FIRST_READS = 10
"""Attempts to hear all servos before the thread starts."""
STARTS_KEPT = 4000


@dataclass
class Recovery:
    deadline: float
    done: threading.Event
    failures: list[str] = field(default_factory=lambda: ["the bus was stopped meanwhile"])


class BusThread(InThread):
    """Serves one bus until it is stopped; whatever fails in it becomes a fault and zero velocity."""

    _patience = 3.0

    def __init__(self, config: ServoConfig, clock: Clock) -> None:
        super().__init__("servo bus", clock)
        self.config = config
        self._log = EventLog[ServoEvent]()
        self._ready: tuple[ReadyServo, ...] = ()
        self._published = clock.condition()
        self._starts: deque[float] = deque(maxlen=STARTS_KEPT)
        self._next = 0.0
        self._connection: Connection | None = None
        self._command: ServoCommand | None = None  # newest; replaced as a whole, so no lock is needed
        self._request: Recovery | None = None

    def _begin(self) -> None:
        connection = Connection(self.config, self._clock)
        connection.open()
        try:
            self._ready = connection.commission(self._log)
            self._cycle = cycle = ServoCycle(connection.quick, self._ready, self.config, self._log)
            if not any(cycle.listen() for _ in range(FIRST_READS)):
                connection.rest()
                raise BackendError("not every servo answers a sync read in time", field="servos.latency",
                                   given=self.config.latency, allowed="longer than adapter and computer take")  # fmt: skip
        except BaseException:
            connection.stop()
            raise
        self._connection, self._latest = connection, cycle.sample(BusState.FOLLOWING)
        self._command, self._request = None, None
        self._starts.clear()
        self._overruns, self._next = 0, self._clock.now()

    def _stuck(self) -> None:
        raise BackendError("the servo bus does not stop", field="servos.port", given=self.config.port,
                           allowed="a device that answers; the servos' watchdogs stop the arm")  # fmt: skip

    def _run(self) -> None:
        try:
            while not self._stopping.is_set():
                self._pace()
                self._guarded(self._turn)
        finally:
            self._guarded(self._finish)
            self._publish(replace(self._latest, state=BusState.STOPPED))
            if self._request is not None:
                self._request.done.set()

    def _pace(self) -> None:
        """Wait for the next cycle; one that is late is not made up for."""
        self._next += self.config.period
        now = self._clock.now()
        if now < self._next:
            self._clock.sleep(self._next - now)
        elif now > self._next + self.config.period:
            self._overruns += 1
            self._next = now

    def _guarded(self, action: Callable[[], None]) -> None:
        """Whatever fails in an action becomes a fault and a stop; the thread lives on."""
        try:
            try:
                action()
            except PortLost:
                raise
            except Exception as error:  # the last line of defence: only this thread commands zero velocity
                self._cycle.bus_fault |= ServoFault.INTERNAL
                self._note(ServoFault.INTERNAL, True, f"internal failure: {type(error).__name__}: {error}")
                self._publish(replace(self._latest, bus_fault=self._cycle.bus_fault, state=BusState.HOLDING))
                if self._connection is not None:
                    self._cycle.halt()
        except PortLost as error:
            self._disconnect(str(error))

    def _turn(self) -> None:
        if self._connection is None:
            self._reconnect()
        else:
            self._cycle_once()
        if self._request is not None:
            request, self._request = self._request, None
            request.failures = ["the serial device is gone"]
            try:
                if self._connection is not None:
                    request.failures = self._cycle.recover(request.deadline, self._breathe)
            finally:
                request.done.set()

    def _cycle_once(self) -> None:
        self._starts.append(self._clock.now())
        self._publish(self._cycle.step(self._command))

    def _breathe(self) -> None:
        """Run a cycle if one is due, in the middle of something longer."""
        if self._stopping.is_set():
            raise BackendError("the bus is being stopped", field="servos")
        if self._clock.now() >= self._next + self.config.period:
            self._next = self._clock.now()
            self._cycle_once()

    def _publish(self, sample: ServoSample) -> None:
        with self._published:
            self._latest = sample
            self._published.notify_all()

    def _note(self, fault: ServoFault, began: bool, text: str) -> None:
        self._log.write(ServoEvent(self._clock.now(), None, fault, began, text))

    def _disconnect(self, why: str) -> None:
        if self._connection is not None:
            self._connection.stop()
            self._connection = None
        self._cycle.bus_fault |= ServoFault.UNPLUGGED
        self._note(ServoFault.UNPLUGGED, True, why)
        self._cycle.count += 1
        self._publish(self._cycle.sample(BusState.DISCONNECTED))

    def _reconnect(self) -> None:
        """Open the device again and check who answers; what the servos went through shows in the next cycle."""
        self._stopping.wait(LONGEST_WAIT)
        self._next = self._clock.now()
        if self._stopping.is_set():
            return
        connection = Connection(self.config, self._clock)
        try:
            connection.open()
            for servo, known in zip(connection.servos(connection.quick), self._cycle.ready, strict=True):
                servo.identify((known.model,))
        except BackendError:  # not there yet, or not whole: tried again
            connection.stop()
            return
        self._connection = connection
        self._cycle.use(connection.quick)
        self._cycle.bus_fault &= ~ServoFault.UNPLUGGED
        self._note(ServoFault.UNPLUGGED, False, "serial device opened again")

    def _finish(self) -> None:
        """Zero velocity, then rest; if that fails, the servos' own watchdogs stop them."""
        connection, self._connection = self._connection, None
        if connection is None:
            return
        try:
            self._cycle.halt()
            for failure in connection.rest():
                text = f"the servo did not take zero velocity, its watchdog stops it: {failure}"
                self._note(ServoFault.NONE, True, text)
        finally:
            connection.stop()
