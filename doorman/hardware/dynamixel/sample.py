"""What the servos said last, with the times at which they said it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

from doorman.arrays import Array
from doorman.hardware.dynamixel.faults import ServoFault


class BusState(Enum):
    """What the adapter does with commands."""

    FOLLOWING = "follows commands"
    HOLDING = "commands zero velocity"
    DISCONNECTED = "has no device"
    STOPPED = "is stopped"


@dataclass(frozen=True)
class ServoSample:
    """State of all servos. Every entry carries the time of its own measurement: nothing old gets a new stamp."""

    time: float
    """When the oldest entry was measured, by `time.monotonic` [s]."""
    angles: Array
    """Joint angles in the URDF's signs and zeros, shape (n,) [rad]."""
    rates: Array
    """Joint rates, shape (n,) [rad/s]."""
    currents: Array
    """Motor currents, positive where they push the angle up, shape (n,) [A]."""
    temperatures: Array
    """Shape (n,) [°C]."""
    voltages: Array
    """Supply, shape (n,) [V]."""
    errors: tuple[int, ...]
    """Hardware error bits of every servo."""
    times: Array
    """When each servo was measured, shape (n,) [s]."""
    faults: tuple[ServoFault, ...]
    """Faults of every servo."""
    bus_fault: ServoFault
    """Faults of the bus."""
    state: BusState
    """What the adapter does with commands."""
    goals: Array
    """Rates that were sent to the joints after this sample was taken, shape (n_joints,) [rad/s]."""
    cycle: int
    """Number of the cycle that wrote this sample."""
    age: float
    """Time between `time` and the call of `ServoBus.read` [s]."""
    fresh: bool
    """Whether every entry is younger than `stale_after`: only then may it be used for control."""

    @property
    def fault(self) -> ServoFault:
        """Everything that is wrong, servos and bus together."""
        union = self.bus_fault
        for fault in self.faults:
            union |= fault
        return union

    def at(self, now: float, stale_after: float) -> ServoSample:
        """This sample with its age at a later time.

        Args:
            now: By `time.monotonic` [s].
            stale_after: Age up to which a sample is fresh [s].
        """
        age = now - self.time
        return replace(self, age=age, fresh=bool(age <= stale_after))


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
