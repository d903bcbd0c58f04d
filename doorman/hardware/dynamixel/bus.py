"""Servo bus: what a backend holds to move an arm of DYNAMIXEL servos."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.checks import vector
from doorman.clocks import REAL_TIME, Clock
from doorman.exceptions import BackendError, DimensionError
from doorman.hardware.dynamixel.bus_thread import BusThread, Recovery
from doorman.hardware.dynamixel.commissioning import Connection, ReadyServo
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.cycle import ServoCommand
from doorman.hardware.dynamixel.faults import BusState, BusStatistics, ServoEvent, ServoSample
from doorman.hardware.dynamixel.registers import FACTORY_CURRENT_LIMITS, MODELS, PRESENT_POSITION, Unit
from doorman.hardware.dynamixel.settings import Servo, SettingFinding, check_settings

T = TypeVar("T")
STRONGEST_GRIP = max(FACTORY_CURRENT_LIMITS[model] * Unit.CURRENT[model] for model in MODELS)
"""What the strongest of the servos takes [A]."""


class ServoBus(BusThread):
    """An arm's servos on one serial bus, in velocity mode, served by a thread of their own.

    `read` and `command` exchange the newest values and return at once: the bus never holds up its user. The constructor touches
    no device. Whatever happens on the bus shows in the samples and events; every fault that matters ends at zero velocity.

    Args:
        config: Servos, joints and limits.
        clock: Clock of all its waits.
    """

    def __init__(self, config: ServoConfig, clock: Clock = REAL_TIME) -> None:
        super().__init__(config, clock)
        self._recovering = clock.lock()

    def inspect(self) -> tuple[SettingFinding, ...]:
        """Open the port, compare every servo's settings with what is relied on, and close it; changes no setting.

        Returns:
            Settings that differ.

        Raises:
            BackendError: if the bus is open, the port cannot be opened, or a servo does not answer or is another model.
        """
        return tuple(finding for findings in self._of_each(check_settings) for finding in findings)

    def positions(self) -> tuple[int, ...]:
        """Open the port, read every servo's present position, and close it; torque stays as it is, so that joints may be held.

        Returns:
            As `zero_position` takes them, in the order of the joints [tick].

        Raises:
            BackendError: if the bus is open, the port cannot be opened, or a servo does not answer or is another model.
        """
        return tuple(self._of_each(lambda servo: servo.read(PRESENT_POSITION)))

    def open(self) -> None:
        """Open the port, make every servo ready and start the thread; the arm stands still with torque on.

        Raises:
            BackendError: if the port cannot be opened, or a servo does not answer, is another model, has settings that are not
                relied on, has shut down or refuses.
        """
        super().open()

    def read(self) -> ServoSample:
        """Newest state of the servos, at once. Look at `fresh` before use.

        Raises:
            BackendError: if the bus was never opened.
        """
        self._require_open()
        return self._latest.at(self._clock.now(), self.config.stale_after)

    def wait(self, sample: ServoSample, timeout: float) -> ServoSample:
        """Wait for a sample that is newer than another.

        Args:
            sample: The other.
            timeout: How long to wait [s].

        Raises:
            BackendError: if none comes in time, or the bus was never opened.
        """
        self._require_open()
        with self._published:
            if not self._published.wait_for(lambda: self._latest.cycle > sample.cycle, timeout):
                raise BackendError("no new sample of the servos", field="servos", given=f"after {timeout:g} s")
            return self._latest.at(self._clock.now(), self.config.stale_after)

    def command(self, rates: ArrayLike, grip: float | None = None) -> None:
        """Ask for joint rates, at once; they hold until the next call, but no longer than `command_timeout`.

        Args:
            rates: Ḣ_d, shape (n_joints,) [rad/s].
            grip: Current of the gripper, up to what the servo takes, positive where it pushes the angle up [A]; None goes
                on with the last one. It holds until it is changed or the bus is stopped; a gripper that has let go by itself,
                as by its watchdog or with the device, stays open until a current is given anew.

        Raises:
            BackendError: if they are of wrong shape, not finite or too large (the arm then stops), or the bus is not open;
                `field` says which.
        """
        self._require_open()
        now, before = self._clock.now(), self._command
        last = (0.0, now) if before is None else (before.current, before.grip_time)
        try:
            wanted = _finite(rates, self.config.n_joints, "rates")
            current, grip_time = last if grip is None else (_grip_current(grip), now)
        except BackendError:
            self._command = ServoCommand((0.0,) * self.config.n_joints, last[0], now, last[1])
            raise
        if self._latest.state is BusState.STOPPED:
            raise BackendError("the servo bus is stopped", allowed="open() before command()")
        self._command = ServoCommand(tuple(float(rate) for rate in wanted), current, now, grip_time)

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
        self._require_open()
        deadline = self._clock.now() + timeout
        if not self._recovering.acquire(timeout=timeout):
            return (f"another recovery has taken more than {timeout:g} s",)
        try:
            self._request = request = Recovery(deadline, self._clock.event())
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
        self._require_open()
        starts = np.array(tuple(self._starts))
        periods = np.diff(starts) if len(starts) > 1 else np.array([self.config.period])
        median, high = np.percentile(periods, [50.0, 99.9])
        return BusStatistics(self._cycle.count, self._overruns, float(median), float(high), float(periods.max()))

    def stop(self) -> None:
        """Command zero velocity, leave the servos at rest with torque on, and close the port; may be called twice."""
        super().stop()

    def _of_each(self, ask: Callable[[Servo], T]) -> list[T]:
        """What every servo answers, over a port that is closed again; nothing is changed but what lets them answer."""
        self._require_closed()
        answers = []
        with Connection(self.config, self._clock) as connection:
            for servo in connection.servos():
                servo.make_answer()
                answers.append(ask(servo))
        return answers


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
