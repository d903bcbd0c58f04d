"""Settings of the adapter: servos, joints and limits."""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array, sealed
from doorman.checks import NonNegative, Positive, Range, check_fields, check_rules, vector
from doorman.exceptions import BackendError
from doorman.hardware.dynamixel.registers import BAUD_CODES, CENTRE, MODELS, TICKS_PER_TURN, WATCHDOG_LONGEST, Unit


class JointLimits(NamedTuple):
    lower: Array  # shape (n,) [rad]
    upper: Array  # shape (n,) [rad]
    rates: Array  # shape (n,) [rad/s]


@dataclass(frozen=True)
class ServoConfig:
    """Servos of an arm, joint by joint from the base to the tip.

    The limits are those of the URDF: `model.vehicle.lower_limits`, `upper_limits` and `rate_limits`.

    Raises:
        BackendError: if a value is out of range.
        DimensionError: if an array has another length than `ids` or is not finite.
    """

    port: str
    """Serial device, best as its link in /dev/serial/by-id."""
    lower_limits: ArrayLike
    """Least joint angles, shape (n,) [rad]."""
    upper_limits: ArrayLike
    """Largest joint angles, shape (n,) [rad]."""
    rate_limits: ArrayLike
    """Largest joint rates, shape (n,) [rad/s]."""
    ids: tuple[int, ...] = (1, 2, 3, 4)
    """Servo of every joint; a gripper's is the last. None for an arm without joints, which needs no port."""
    gripper: bool = False
    """Whether the last servo is a gripper's, which a current closes and a spring opens. It goes on following commands while
    another servo has failed, and opens by itself when it hears nothing, has shut down or has no power."""
    directions: tuple[int, ...] | None = None
    """+1 where the servo's positive direction (counter-clockwise, seen onto its horn) is the joint's, else −1."""
    zero_positions: tuple[int, ...] | None = None
    """Present position at the joint's zero; by default the middle of the turn, 2048 [tick]."""
    homing_offsets: tuple[int, ...] | None = None
    """Homing offset that every servo must hold in its EEPROM; by default 0 [tick]."""
    models: tuple[int, ...] = tuple(MODELS)
    """Model numbers that are accepted."""
    baud_rate: int = 1_000_000
    """Rate of the bus [bit/s]."""
    rate: Annotated[float, Range(0.0, 1000.0, "1/s", above=True)] = 200.0
    """Cycles per second; each reads all servos and commands them [1/s]."""
    latency: Positive = 0.004
    """What USB adapter and computer may add to an answer's time on the wire [s]."""
    setup_latency: Positive = 0.03
    """What adapter and computer may add while servos are set up, when nothing is urgent [s]."""
    open_timeout: Positive = 10.0
    """`open` gives up after this [s]."""
    boot_timeout: Positive = 3.0
    """A rebooted servo must answer within this [s]."""
    command_timeout: Positive = 0.1
    """Without a new command for this long, the arm stops [s]."""
    watchdog: float = 0.1
    """A servo that hears nothing for this long stops by itself; a gripper's goes limp; multiples of 0.02 up to 2.54 [s]."""
    stale_after: Positive = 0.03
    """A servo without a fresh answer for this long stops the arm [s]."""
    missing_after: Positive = 0.25
    """A servo without a fresh answer for this long counts as missing [s]."""
    warm_temperature: float = 60.0
    """Temperature above which a servo is reported as warm [°C]."""
    hot_temperature: float = 70.0
    """Temperature above which the arm stops, until it is 5 °C colder; a servo shuts down at its own limit, 80 by default [°C]."""
    strain_current: Positive = 1.4
    """Current above which a servo is reported as strained, after `strain_time` [A]."""
    strain_time: Positive = 0.3
    """How long a servo draws `strain_current` before it is reported as strained [s]."""
    deceleration: Positive = 10.0
    """Deceleration with which the joints brake ahead of a limit [rad/s²]."""
    reaction_time: NonNegative = 0.03
    """Time between a command and the servo's motion, which the braking law allows for [s]."""
    limit_margin: NonNegative = 0.01
    """The joints stop this far before their limits [rad]."""
    limit_tolerance: NonNegative = 0.03
    """A joint this far outside its limits is reported [rad]."""
    write_eeprom: bool = False
    """Whether `open` may change EEPROM settings; the arm goes limp for that."""
    torque_off_at_stop: bool = False
    """Whether `stop` lets the arm go limp after it has stopped it."""
    limits: JointLimits = field(init=False, repr=False)
    """The same limits as read-only arrays."""

    def __post_init__(self) -> None:
        mounting = ("directions", "zero_positions", "homing_offsets")
        for name in ("ids", *mounting):
            self._make_whole(name)
        known = set(self.models) <= set(MODELS) and len(self.models) > 0
        check_rules(
            self, "servos.",
            (self.n > 0 or not np.size(self.lower_limits), "ids", "one for each joint of the arm"),
            (len(set(self.ids)) == self.n, "ids", "distinct ids"),
            (all(0 <= servo_id <= 252 for servo_id in self.ids), "ids", "0 … 252"),
            (self.n_joints >= 1 or not self.gripper, "ids", "with a gripper, two at least"),
            (known, "models", ", ".join(f"{number} ({name})" for number, name in MODELS.items())),
            (self.baud_rate in BAUD_CODES, "baud_rate", ", ".join(map(str, BAUD_CODES))),
            *((len(values) == self.n, name, f"{self.n} values") for name in mounting
              if (values := getattr(self, name)) is not None),
        )  # fmt: skip
        names = ("lower_limits", "upper_limits", "rate_limits")
        lower, upper, rates = (sealed(vector(getattr(self, name), self.n, f"servos.{name}")) for name in names)
        object.__setattr__(self, "limits", JointLimits(lower, upper, rates))
        check_fields(self, "servos.")
        bound, counts = 255 * TICKS_PER_TURN, self.watchdog / Unit.WATCHDOG
        room = float(np.min(upper - lower, initial=math.inf))
        check_rules(
            self, "servos.",
            (bool((upper > lower).all()), "upper_limits", "above the lower limits"),
            (bool((rates > 0.0).all()), "rate_limits", "> 0 rad/s"),
            (set(self.signs) <= {1, -1}, "directions", "1 or -1"),
            (all(abs(zero) <= bound for zero in self.zeros), "zero_positions", f"up to {bound}"),
            (all(abs(offset) < bound for offset in self.offsets), "homing_offsets", f"below {bound}"),
            (self.missing_after > self.stale_after > self.period, "stale_after", "between period and missing_after"),
            (any(abs(counts - whole) < 1e-6 for whole in range(1, WATCHDOG_LONGEST + 1)), "watchdog",
             f"multiples of {Unit.WATCHDOG} up to {WATCHDOG_LONGEST * Unit.WATCHDOG} s"),
            (self.watchdog > 4.0 * self.period, "watchdog", "more than four periods"),
            (self.hot_temperature > self.warm_temperature, "hot_temperature", "above warm_temperature"),
            (2.0 * self.limit_margin < room, "limit_margin", f"below {room / 2.0:g} rad"),
        )  # fmt: skip

    @property
    def n(self) -> int:
        """Number of servos."""
        return len(self.ids)

    @property
    def n_joints(self) -> int:
        """Number of joints that are commanded by rates: all but the gripper."""
        return self.n - self.gripper

    @property
    def period(self) -> float:
        """Period of a cycle [s]."""
        return 1.0 / self.rate

    @property
    def signs(self) -> tuple[int, ...]:
        """Direction of every servo."""
        return self.directions or (1,) * self.n

    @property
    def zeros(self) -> tuple[int, ...]:
        """Present position at every joint's zero [tick]."""
        return self.zero_positions or (CENTRE,) * self.n

    @property
    def offsets(self) -> tuple[int, ...]:
        """Homing offset that every servo must hold [tick]."""
        return self.homing_offsets or (0,) * self.n

    @property
    def watchdog_counts(self) -> int:
        """Content of the bus watchdog's register."""
        return round(self.watchdog / Unit.WATCHDOG)

    def _make_whole(self, name: str) -> None:
        """Make Python's integers of what counts as such: a float fits into no register."""
        values = getattr(self, name)
        if values is None:
            return
        try:
            object.__setattr__(self, name, tuple(operator.index(value) for value in values))
        except TypeError as error:
            raise BackendError(
                "not whole numbers", field=f"servos.{name}", given=values, allowed="whole numbers"
            ) from error
