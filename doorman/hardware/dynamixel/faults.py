"""What servos said last, and what can be wrong with them and their bus: what follows from it, and the log of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum, Flag, auto
from functools import reduce
from operator import or_

from doorman.arrays import Array


class ServoFault(Flag):
    """What is wrong with one servo or with the bus; several may hold at once."""

    NONE = 0

    TIMEOUT = auto()
    """No answer in this cycle."""
    CORRUPT = auto()
    """A damaged answer in this cycle, or nothing but noise."""
    LATE = auto()
    """The servo's clock says that the answer is older than the question."""
    REFUSED = auto()
    """The servo answered with an error number."""
    STALE = auto()
    """No fresh answer for `stale_after`."""
    MISSING = auto()
    """No fresh answer for `missing_after`."""
    WATCHDOG = auto()
    """The servo's bus watchdog fired: it heard nothing for too long and stopped."""
    RESTARTED = auto()
    """The servo restarted and forgot its set-up, as after a dip of its supply."""
    TORQUE_OFF = auto()
    """Torque is off though it was switched on."""
    VOLTAGE = auto()
    """The servo reports its supply out of bounds."""
    OVERHEATING = auto()
    """The servo shut down by heat."""
    ENCODER = auto()
    """The servo reports a broken encoder."""
    SHOCK = auto()
    """The servo reports an electrical shock or too weak a supply."""
    OVERLOAD = auto()
    """The servo shut down by overload."""
    WARM = auto()
    """Above `warm_temperature`."""
    HOT = auto()
    """Above `hot_temperature`: stopped before the servo shuts itself down."""
    STRAINED = auto()
    """Above `strain_current` for `strain_time`: an overload is near."""
    OUT_OF_LIMITS = auto()
    """The joint is outside its limits; it can only move back."""
    WRONG_MODEL = auto()
    """Another model answers than before."""
    JUMPED = auto()
    """The angle jumped by more than the servo can turn: its zero is another one now, or its encoder slips."""

    UNPLUGGED = auto()
    """Bus: the serial device is gone."""
    COMMAND_STALE = auto()
    """Bus: no new command for `command_timeout`."""
    INTERNAL = auto()
    """Bus: the adapter itself failed."""


WARNINGS = (
    ServoFault.TIMEOUT
    | ServoFault.CORRUPT
    | ServoFault.LATE
    | ServoFault.REFUSED
    | ServoFault.VOLTAGE
    | ServoFault.WARM
    | ServoFault.STRAINED
    | ServoFault.OUT_OF_LIMITS
)
"""Reported, but the arm goes on; a lasting one of the first four becomes `STALE`."""
STOPPING = (
    ServoFault.STALE
    | ServoFault.MISSING
    | ServoFault.WATCHDOG
    | ServoFault.HOT
    | ServoFault.UNPLUGGED
    | ServoFault.COMMAND_STALE
)
"""Every joint is commanded to zero velocity until they have passed; a gripper goes on following its commands."""
LATCHED = (
    ServoFault.RESTARTED
    | ServoFault.TORQUE_OFF
    | ServoFault.OVERHEATING
    | ServoFault.ENCODER
    | ServoFault.SHOCK
    | ServoFault.OVERLOAD
    | ServoFault.WRONG_MODEL
    | ServoFault.JUMPED
    | ServoFault.INTERNAL
)
"""Every joint is commanded to zero velocity until `ServoBus.recover` succeeds."""


@dataclass(frozen=True)
class ServoEvent:
    """A fault that began or ended, or something that was done about it."""

    time: float
    """When, by `time.monotonic` [s]."""
    servo_id: int | None
    """None where the whole bus is meant."""
    fault: ServoFault
    """Which; `NONE` where something was done."""
    began: bool
    """False where it ended."""
    text: str
    """What happened, in words."""

    def __str__(self) -> str:
        who = "servo bus" if self.servo_id is None else f"servo {self.servo_id}"
        return f"{who}: {self.text}"


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
        return reduce(or_, self.faults, self.bus_fault)

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
