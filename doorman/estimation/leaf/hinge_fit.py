r"""A hinge's resistance: its shares of friction, closer and damping, from the motion so far.

With the way's sense s, the resistance that the bank finds at an angle and a rate is

.. math:: \rho - s\,\tau_p = b\,|\dot q| + \tau_c + s\,k\,(q - q_0) + w .

One speed teaches the sum of damping and friction alone, and a standing leaf nothing: b, τ_c and k stay correlated then.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.model import Model
from doorman.scenario.sections.estimation import USUAL_HINGE
from doorman.stored_at_once import stored_at_once

_EVERY = 1.0
"""Between looks, over which what the leaf resists with by chance is a new one [s]."""
_BY_CHANCE = 0.1
"""Deviation of what a room door's hinge resists with beside b, τ_c and k, in still air [N m]."""
_IN_WIND = 0.3
"""Growth of that deviation with the wind on the vehicle [m]."""
_MOVES = 0.02
"""Rate of the shipped leaf below which it tells nothing [rad/s]."""


@stored_at_once
@dataclass(frozen=True)
class HingeEstimate:
    """Parameters of the hinge with their standard deviations, SI units."""

    damping: float
    friction: float
    stiffness: float
    inertia: float
    damping_deviation: float
    friction_deviation: float
    stiffness_deviation: float
    inertia_deviation: float
    torque_deviation: float
    """Standard deviation of friction and closer together at the present angle [N m]."""


class HingeFit:
    """b, τ_c and k of one hinge."""

    def __init__(self, model: Model) -> None:
        door, scale = model.door, model.ratios["hinge"]
        usual = {name: (scale * mean, scale * doubt) for name, (mean, doubt) in USUAL_HINGE.items()}
        self._door, self._sense = door, model.travel.sense
        self._by_chance, self._moves = _BY_CHANCE * scale, _MOVES * model.ratios["rate"]
        self._mean = np.array([getattr(door, name) or mean for name, (mean, _) in usual.items()])
        self._believe(np.diag([doubt**2 for _, doubt in usual.values()]))
        self._next = -math.inf

    def _believe(self, covariance: Array) -> None:
        self._covariance, (_, (_, of_friction, together), (_, _, of_stiffness)) = covariance, covariance.tolist()
        self._doubts = np.sqrt(np.maximum(covariance.diagonal(), 0.0)).tolist(), of_friction, of_stiffness, together
        """Deviations of damping, friction and stiffness, the variances of the last two, and their covariance."""

    def learn(self, now: float, angle: float, rate: float, resistance: float, deviation: float, wind: float) -> None:
        """Take in what a leaf that is pushed along resists with."""
        if now < self._next or abs(rate) < self._moves:
            return
        self._next = now + _EVERY
        way = math.copysign(1.0, rate)
        slope = np.array([abs(rate), 1.0, way * (angle - self._door.rest_angle)])
        felt = way * self._sense * resistance - way * self._door.closing_torque
        noise = deviation**2 + (self._by_chance + _IN_WIND * wind) ** 2
        spread = self._covariance @ slope
        variance = float(slope @ spread) + noise
        self._mean = np.maximum(self._mean + spread * ((felt - float(slope @ self._mean)) / variance), 0.0)
        self._believe(self._covariance - np.outer(spread, spread) / variance)

    def stays(self, angle: float) -> None:
        """The leaf has stood here with nothing at it: friction is at least what closer and weight make."""
        self._mean[1] = max(float(self._mean[1]), 1.001 * self._closes(angle))

    def friction_share(self, angle: float) -> float:
        """Share of what resists that does not drive the leaf back."""
        friction, closes = float(self._mean[1]), self._closes(angle, weight=False)
        return friction / max(friction + closes, 1e-9)

    def found(self, angle: float, inertia: float, inertia_deviation: float) -> HingeEstimate:
        """What is known at an angle."""
        turned, (deviations, of_friction, of_stiffness, together) = abs(angle - self._door.rest_angle), self._doubts
        squares, together = of_friction + turned**2 * of_stiffness, 2.0 * turned * together
        damping, friction, stiffness = self._mean.tolist()
        return HingeEstimate(
            damping, friction, stiffness, inertia, deviations[0], deviations[1], deviations[2], inertia_deviation,
            math.sqrt(max(squares + together, 0.0)),
        )  # fmt: skip

    def _closes(self, angle: float, weight: bool = True) -> float:
        """Torque of closer, and of the leaf's weight, that drives the leaf [N m]."""
        known = abs(self._door.closing_torque + (self._door.weight_torque(angle) if weight else 0.0))
        return float(self._mean[2]) * abs(angle - self._door.rest_angle) + known
