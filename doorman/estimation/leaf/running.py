"""The bank at the leaf through a flight: one step for each pose, and a new beginning where it cannot go on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.estimation.estimate import FilterEstimate
from doorman.estimation.leaf.hypotheses import FREE
from doorman.estimation.leaf.leaf_filter import AWAY, leaf_filter
from doorman.estimation.leaf.leaf_sensor import LEAF
from doorman.estimation.leaf.numbers import PLACES, first_state
from doorman.estimation.status import Status
from doorman.kinematics.numbers import Numbers
from doorman.model import Model

Array = NDArray[np.float64]

_ENDED = (Status.LOST, Status.NOT_STARTED, Status.CLOCK)
"""After these the filter begins anew, where it was."""

_REFUSED_LONGEST = 0.1
"""Time for which poses may be refused: they are not outliers if they go on, but a blow that the filter has not seen [s]."""

_SPEED = 0.5
"""Speed of a vehicle of which nothing is known [m/s]."""


class LeafRun:
    """What is known of vehicle and leaf, from pose to pose.

    Args:
        model: Of the scenario.
        numbers: Of `leaf_numbers`.
        time: Of the first pose [s].
        position: Of the first pose, shape (3,) [m].
        inputs: As `LeafMotion` has them, shape (m,).
        feels: Whether the tip's force is read.
    """

    def __init__(
        self, model: Model, numbers: Numbers, time: float, position: Array, inputs: Array, *, feels: bool = False
    ) -> None:
        self._bank, self._situation, self._inputs = leaf_filter(model, numbers, feels), AWAY, inputs
        self._numbers = numbers
        mean, self._doubt = first_state(model, numbers, position)
        self._bank.start(time, mean, self._doubt, probabilities={FREE: 1.0}, inputs=inputs, situation=AWAY)
        self.estimate: FilterEstimate = self._bank.estimate()
        """At the last pose."""
        self._taken, self._likelihood, self._fused, self._refused, self._innovation = time, 0.0, 0, 0, 0.0

    def step(self, time: float, position: Array, inputs: Array, situation: str, felt: Array | None = None) -> Status:
        """Go on to a pose.

        Args:
            time: At which it was true [s].
            position: Shape (3,) [m].
            inputs: At that time, shape (m,); until then their mean with the last ones acted.
            situation: As in `Filter.allow`.
            felt: What the tip's sensor reads, shape (1,) [N].

        Returns:
            The worst that happened; `LOST` where the filter began anew.
        """
        bank = self._bank
        if situation != self._situation:
            self._situation = situation
            bank.allow(situation)
        if not np.isfinite(inputs).all():
            return Status.NOT_FINITE
        bank.acted(0.5 * (self._inputs + inputs))
        self._inputs = inputs
        told = bank.measure("pose", time, position)
        if felt is not None:
            told = max(told, bank.measure("tip_force", time, felt))
        status = max(told, bank.step(time, inputs))
        if status < Status.REFUSED or time < self._taken:
            self._taken = time
        if status in _ENDED or time - self._taken > _REFUSED_LONGEST:
            self._begin_anew(time, position)
            status = max(status, Status.LOST)
        self.estimate = bank.estimate()
        return status

    def see_leaf(self, time: float, joint: float, deviation: float) -> Status:
        """Take in where a sensor has seen the leaf; the next step fuses it at its own time.

        Args:
            time: At which it was true [s].
            joint: q [rad].
            deviation: Of q [rad]; that of the last reading holds for all that one step fuses.

        Returns:
            Whether it was taken.
        """
        self._bank.parameters[self._numbers.place("sensor.leaf")] = deviation
        return self._bank.measure(LEAF, time, [joint])

    @property
    def log_likelihood(self) -> float:
        """Of all fused readings."""
        return self._likelihood + self._bank.log_likelihood

    @property
    def refused(self) -> int:
        """Poses beyond their gate."""
        return self._refused + self._bank.score("pose").refused

    @property
    def mean_nis(self) -> float:
        """Mean NIS of the poses."""
        score = self._bank.score("pose")
        total = self._innovation + (score.mean_nis * score.fused if score.fused else 0.0)
        return total / max(self._fused + score.fused, 1)

    def _begin_anew(self, time: float, position: Array) -> None:
        """What was known of the leaf stays, as far as it is not known better than at the start."""
        score, known = self._bank.score("pose"), self.estimate
        self._likelihood += self._bank.log_likelihood
        self._fused, self._refused = self._fused + score.fused, self._refused + score.refused
        self._innovation += score.mean_nis * score.fused if score.fused else 0.0
        mean = known.mean.copy()
        mean[PLACES["velocity"]] = 0.0
        if np.isfinite(position).all():
            mean[PLACES["position"]] = position
        doubt = np.maximum(self._doubt, known.deviations)
        doubt[PLACES["velocity"]] = np.maximum(doubt[PLACES["velocity"]], _SPEED)
        self._bank.start(time, mean, doubt, inputs=self._inputs, situation=self._situation)
        self._taken = time
