"""Servo bus: what a backend holds to move an arm of DYNAMIXEL servos."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.background import Opened
from doorman.checks import vector
from doorman.clocks import REAL_TIME, Clock
from doorman.exceptions import BackendError, DimensionError
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.cycle import ServoCommand, ServoCycle
from doorman.hardware.dynamixel.faults import ServoEvent
from doorman.hardware.dynamixel.sample import BusState, ServoSample
from doorman.hardware.dynamixel.setup.commissioning import ReadyServo
from doorman.hardware.dynamixel.setup.settings import SettingFinding
from doorman.hardware.dynamixel.wire.connection import Connection
from doorman.hardware.dynamixel.worker import BusStatistics, BusWorker, RecoveryRequest
from doorman.hardware.events import EventLog

FIRST_READS = 10
"""Attempts to hear all servos before the thread starts."""
STRONGEST_GRIP = 2.0
"""More than any of the servos takes [A]."""


class ServoBus(Opened):
    """An arm's servos on one serial bus, in velocity mode, served by a thread of their own.

    `read` and `command` exchange the newest values and return at once: the bus never holds up its user. The constructor touches
    no device. Whatever happens on the bus shows in the samples and events; every fault that matters ends at zero velocity.

    Args:
        config: Servos, joints and limits.
        clock: By which it waits.
    """

    def __init__(self, config: ServoConfig, clock: Clock = REAL_TIME) -> None:
        self.config, self._clock = config, clock
        self._log = EventLog[ServoEvent]()
        self._worker: BusWorker | None = None
        self._ready: tuple[ReadyServo, ...] = ()
        self._recovering = clock.lock()

    def inspect(self) -> tuple[SettingFinding, ...]:
        """Open the port, compare every servo's settings with what is relied on, and close it; changes no setting.

        Returns:
            Settings that differ.

        Raises:
            BackendError: if the bus is open, the port cannot be opened, or a servo does not answer or is another model.
        """
        with self._for_a_moment() as connection:
            return tuple(connection.inspect(self.config))

    def positions(self) -> tuple[int, ...]:
        """Open the port, read every servo's present position, and close it; torque stays as it is, so that joints may be held.

        Returns:
            As `zero_position` takes them, in the order of the joints [tick].

        Raises:
            BackendError: if the bus is open, the port cannot be opened, or a servo does not answer or is another model.
        """
        with self._for_a_moment() as connection:
            return tuple(connection.positions(self.config))

    def open(self) -> None:
        """Open the port, make every servo ready and start the thread; the arm stands still with torque on.

        Raises:
            BackendError: if the port cannot be opened, or a servo does not answer, is another model, has settings that are not
                relied on, has shut down or refuses.
        """
        self._require_closed()
        connection = Connection.open(self.config, self._clock)
        try:
            self._ready = connection.commission(self.config, self._log)
            self._worker = self._hear_all(connection)
            self._worker.open()
        except BaseException:
            self._worker = None
            connection.port.close()
            raise

    def read(self) -> ServoSample:
        """Newest state of the servos, at once. Look at `fresh` before use.

        Raises:
            BackendError: if the bus was never opened.
        """
        return self._opened().latest.at(self._clock.now(), self.config.stale_after)

    def wait(self, sample: ServoSample, timeout: float) -> ServoSample:
        """Wait for a sample that is newer than another.

        Args:
            sample: The other.
            timeout: How long to wait [s].

        Raises:
            BackendError: if none comes in time, or the bus was never opened.
        """
        return self._opened().wait(sample.cycle, timeout).at(self._clock.now(), self.config.stale_after)

    def command(self, rates: ArrayLike, grip: float | None = None) -> None:
        """Ask for joint rates, at once; they hold until the next call, but no longer than `command_timeout`.

        Args:
            rates: Ḣ_d, shape (n_joints,) [rad/s].
            grip: Current of the gripper, up to ±2 and what the servo takes, positive where it pushes the angle up [A]; None goes
                on with the last one. It holds until it is changed or the bus is stopped; a gripper that has let go by itself,
                as by its watchdog or with the device, stays open until a current is given anew.

        Raises:
            BackendError: if they are of wrong shape, not finite or too large (the arm then stops), or the bus is not open;
                `field` says which.
        """
        worker = self._opened()
        now = self._clock.now()
        last = (0.0, now) if worker.command is None else (worker.command.current, worker.command.grip_time)
        try:
            wanted = _finite(rates, self.config.n_joints, "rates")
            current, grip_time = last if grip is None else (_grip_current(grip), now)
        except BackendError:
            worker.command = ServoCommand((0.0,) * self.config.n_joints, last[0], now, last[1])
            raise
        if worker.latest.state is BusState.STOPPED:
            raise BackendError("the servo bus is stopped", allowed="open() before command()")
        worker.command = ServoCommand(tuple(float(rate) for rate in wanted), current, now, grip_time)

    def recover(self, timeout: float = 10.0) -> tuple[str, ...]:
        """Set up again every servo that is missing or has a latched fault; one that has shut down is rebooted.

        A rebooted servo gives way meanwhile. It blocks, so it is not for the controller's thread; the bus goes on. Who calls it
        while another does waits for the other first.

        Args:
            timeout: How long it may take, the wait for another included [s].

        Returns:
            What failed, in words; nothing if all servos are well.

        Raises:
            BackendError: if the bus is not open.
        """
        worker = self._opened()
        deadline = self._clock.now() + timeout
        if not self._recovering.acquire(timeout=timeout):
            return (f"another recovery has taken more than {timeout:g} s",)
        try:
            request = RecoveryRequest(deadline, self._clock.event())
            worker.request = request
            if not request.done.wait(deadline - self._clock.now() + self.config.boot_timeout):
                return (f"the servos did not recover within {timeout:g} s",)
            return tuple(request.failures)
        finally:
            self._recovering.release()

    def events(self) -> list[ServoEvent]:
        """Take what has happened since the last call, oldest first."""
        return self._log.take()

    @property
    def servos(self) -> tuple[ReadyServo, ...]:
        """What is known of every servo since `open`: model, firmware, limits, settings that differ."""
        return self._ready

    @property
    def statistics(self) -> BusStatistics:
        """How the cycles ran.

        Raises:
            BackendError: if the bus was never opened.
        """
        return self._opened().statistics()

    def stop(self) -> None:
        """Command zero velocity, leave the servos at rest with torque on, and close the port; may be called twice."""
        worker, self._worker = self._worker, None
        if worker is not None:
            worker.stop()

    def _hear_all(self, connection: Connection) -> BusWorker:
        """Worker with a first sample of all servos."""
        cycle = ServoCycle(connection.quick, self._ready, self.config, self._log)
        for _ in range(FIRST_READS):
            if cycle.listen():
                return BusWorker(connection, cycle, self.config, self._log, cycle.sample(BusState.FOLLOWING))
        connection.rest(self.config)
        raise BackendError("not every servo answers a sync read in time", field="servos.latency",
                           given=self.config.latency, allowed="longer than adapter and computer take")  # fmt: skip

    @contextmanager
    def _for_a_moment(self) -> Iterator[Connection]:
        """The port, closed again afterwards."""
        self._require_closed()
        connection = Connection.open(self.config, self._clock)
        try:
            yield connection
        finally:
            connection.port.close()

    def _require_closed(self) -> None:
        if self._worker is not None:
            raise BackendError("the servo bus is open already", allowed="stop() before another open()")

    def _opened(self) -> BusWorker:
        if self._worker is None:
            raise BackendError("the servo bus is not open", allowed="open() before read() and command()")
        return self._worker


def _finite(values: ArrayLike, size: int, field: str) -> NDArray[np.float64]:
    try:
        return vector(values, size, field)
    except DimensionError as error:
        raise BackendError(f"not {field}: {error}", field=field) from error


def _grip_current(grip: float) -> float:
    current = float(_finite([grip], 1, "grip")[0])
    if abs(current) > STRONGEST_GRIP:
        raise BackendError("no servo takes so much current", field="grip", given=current,
                           allowed=f"-{STRONGEST_GRIP:g} to {STRONGEST_GRIP:g} A")  # fmt: skip
    return current
