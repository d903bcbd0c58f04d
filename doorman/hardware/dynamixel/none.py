"""No servos: the arm of a vehicle whose tip is fixed to it, such as a stick. It has no device, and nothing of it gets old."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from doorman.background import Opened
from doorman.clocks import REAL_TIME, Clock
from doorman.hardware.dynamixel.commissioning import ReadyServo
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.faults import BusState, BusStatistics, ServoEvent, ServoFault, ServoSample


class NoServos(Opened):
    """What `ServoBus` is for an arm of no joints.

    Args:
        config: Without ids.
        clock: Clock of its samples' stamps.
    """

    servos: tuple[ReadyServo, ...] = ()
    """None."""

    def __init__(self, config: ServoConfig, clock: Clock = REAL_TIME) -> None:
        self.config, self._clock = config, clock

    def open(self) -> None:
        """Nothing is opened."""

    def stop(self) -> None:
        """Nothing is closed."""

    def read(self) -> ServoSample:
        """An empty sample of now."""
        none = np.zeros(0)
        return ServoSample(
            time=self._clock.now(), angles=none, rates=none, currents=none, temperatures=none, voltages=none, errors=(),
            times=none, faults=(), bus_fault=ServoFault(0), state=BusState.FOLLOWING, goals=none, cycle=0, age=0.0, fresh=True,
        )  # fmt: skip

    def wait(self, sample: ServoSample, timeout: float) -> ServoSample:
        """The same, at once."""
        return self.read()

    def command(self, rates: ArrayLike, grip: float | None = None) -> None:
        """Nothing moves."""

    def recover(self, timeout: float = 10.0) -> tuple[str, ...]:
        """Nothing fails."""
        return ()

    def events(self) -> list[ServoEvent]:
        """None."""
        return []

    @property
    def statistics(self) -> BusStatistics:
        """No cycle has run."""
        return BusStatistics(0, 0, self.config.period, self.config.period, self.config.period)
