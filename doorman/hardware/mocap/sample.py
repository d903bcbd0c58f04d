r"""The body's pose as measured last, or carried on from there for a short while.

.. math::
    P(t) = P + v\,(t - t_0), \qquad q(t) = q \exp\bigl(\Omega\,(t - t_0)\bigr)
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from typing import Protocol, runtime_checkable

from doorman.arrays import Array, frozen
from doorman.hardware.interface import Source
from doorman.hardware.mocap.faults import MocapFault
from doorman.kinematics.quaternions import Quaternion, Vector, from_rotation_vector, multiply, to_attitude


class PoseQuality(Enum):
    """What a pose is worth."""

    NONE = "none yet"
    """The object has not been seen; the numbers are NaN."""
    MEASURED = "measured"
    """Younger than `stale_after`, and as measured."""
    PREDICTED = "predicted"
    """Carried on with constant velocity and body rates to the time of the call, for at most `prediction_limit`."""
    LOST = "lost"
    """Where the body was last seen: not to be flown on."""

    @property
    def usable(self) -> bool:
        """Whether a controller may use such a pose: measured or predicted."""
        return self in (PoseQuality.MEASURED, PoseQuality.PREDICTED)


@dataclass(frozen=True)
class PoseSample:
    """A pose of the body, with the time at which it was measured: nothing old gets a new stamp."""

    time: float
    """When the measurement behind it was true, by `time.monotonic` [s]; −∞ before the first."""
    position: Array
    """P of O_B, shape (3,), world frame [m]."""
    attitude: Array
    """Φ = [φ, θ, ψ], ZYX, shape (3,) [rad]."""
    quaternion: Array
    """[w, x, y, z], body to world, shape (4,)."""
    velocity: Array
    """Ṗ, shape (3,), world frame [m/s]; filtered, and so as late as `MocapStatistics.velocity_lag`."""
    body_rates: Array
    """Ω, shape (3,), body frame [rad/s]; filtered by the same."""
    frame_number: int
    """Vicon's, modulo 2³²; −1 before the first."""
    count: int
    """Poses that were measured up to this one."""
    fault: MocapFault
    """Everything that is wrong."""
    age: float
    """Time between `time` and the call of `MocapReceiver.read` [s]."""
    fresh: bool
    """Whether the pose is `MEASURED`: only then may it be handed on as a measurement."""
    quality: PoseQuality
    origin: PoseSample | None = None
    """Measurement from which a predicted pose was extrapolated."""
    track: int = 0
    """Grows by one whenever the body is found again after a gap longer than `stale_after`: it may be another body then."""
    shift: Vector = (0.0, 0.0, 0.0)
    """Sum of the body's jumps that were seen without a gap in which it can have moved, world frame [m]."""
    lateness: float = 0.0
    """Age with which it arrived [s]."""

    @property
    def usable(self) -> bool:
        """Whether a controller may use the pose: measured or predicted."""
        return self.quality.usable

    def at(self, now: float, stale_after: float, prediction_limit: float) -> PoseSample:
        """This measurement as of a later time.

        Args:
            now: By `time.monotonic` [s].
            stale_after: Age up to which it counts as measured [s].
            prediction_limit: Age up to which it is predicted [s].

        Returns:
            The same pose, or, if it is stale, the one predicted for `now`, or the old one, marked as lost.
        """
        age = now - self.time
        if self.count == 0:
            return replace(self, age=math.inf)
        if age <= stale_after:
            return replace(self, age=age, fresh=True, quality=PoseQuality.MEASURED)
        if age > prediction_limit:
            return replace(self, age=age, fresh=False, quality=PoseQuality.LOST)
        return self._predicted(age)

    def _predicted(self, age: float) -> PoseSample:
        w, x, y, z = self.quaternion.tolist()
        turn_x, turn_y, turn_z = (age * self.body_rates).tolist()
        quaternion = multiply((w, x, y, z), from_rotation_vector((turn_x, turn_y, turn_z)))
        return replace(
            self,
            position=frozen(self.position + age * self.velocity),
            attitude=frozen(to_attitude(quaternion)),
            quaternion=frozen(quaternion),
            age=age,
            fresh=False,
            quality=PoseQuality.PREDICTED,
            origin=self,
        )


@runtime_checkable
class PoseSource(Source[PoseSample], Protocol):
    """`MocapReceiver` is one for every kind of `connection`.

    It judges what it brings: `PoseSample` says how old the pose is, whether it was measured, and what is wrong.
    """


def measured(
    time: float,
    position: Vector,
    quaternion: Quaternion,
    velocity: Vector,
    body_rates: Vector,
    frame_number: int,
    count: int,
    track: int = 0,
    shift: Vector = (0.0, 0.0, 0.0),
    lateness: float = 0.0,
) -> PoseSample:
    return PoseSample(
        time, frozen(position), frozen(to_attitude(quaternion)), frozen(quaternion), frozen(velocity),
        frozen(body_rates), frame_number, count, MocapFault.NONE, 0.0, True, PoseQuality.MEASURED, track=track, shift=shift,
        lateness=lateness,
    )  # fmt: skip


def nothing_yet() -> PoseSample:
    three, four = frozen((math.nan,) * 3), frozen((math.nan,) * 4)
    return PoseSample(
        -math.inf, three, three, four, three, three, -1, 0, MocapFault.NONE, math.inf, False, PoseQuality.NONE
    )
