"""How old and how noisy the poses are in flight, and whether contact bears that."""

from __future__ import annotations

import math
import statistics
from collections import deque

import numpy as np

from doorman.control.estimation.pose_age import oldest_pose
from doorman.control.estimation.pose_noise import force_noise, most_force_noise
from doorman.model import Model
from doorman.position_noise import PositionNoise
from doorman.signals import Measurement

_KEPT = 1000
_ENOUGH = 50
"""Poses from which on they are judged."""
_OLD = 90.0
"""Percentile of the ages: what comes once in ten poses is no gap."""
_GAP = 1.6
"""Intervals, after which a pose is missing."""


class PoseWatch:
    """Measures the poses of one flight, the last thousand of them, against `pose_age` and `pose_noise`."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._noise = PositionNoise()
        self._number, self._pose_time, self._age = 0, math.nan, 0.0
        self._intervals: deque[float] = deque(maxlen=_KEPT)
        self._young: deque[float] = deque(maxlen=_KEPT)
        self._old: deque[float] = deque(maxlen=_KEPT)

    def note(self, measured: Measurement) -> None:
        """Take in one measurement; what has not changed since the last one counts as age alone."""
        before, self._age = self._age, measured.time - measured.pose_time
        if measured.pose_time == self._pose_time:
            return
        interval = measured.pose_time - self._pose_time
        self._pose_time = measured.pose_time
        if not math.isnan(interval):
            self._intervals.append(interval)
            self._young.append(self._age)
            self._old.append(before)
            self._number += 1 if interval < _GAP * self._interval else 2
        self._noise.note(self._number, measured.position)

    @property
    def _interval(self) -> float:
        return statistics.median(self._intervals)

    @property
    def judged(self) -> bool:
        """Whether enough poses have come to judge them."""
        return len(self._intervals) >= _ENOUGH and not math.isnan(self._noise.deviation)

    def unfit(self) -> str:
        """Why contact does not bear these poses."""
        if not self.judged:
            return ""
        model, old = self._model, float(np.percentile(self._old, _OLD))
        if old > (limit := oldest_pose(model.scenario.control)):
            return f"the poses are too old for contact: {1e3 * old:.0f} ms; allowed: {1e3 * limit:.0f} ms"
        noise, young = self._noise.deviation, max(statistics.median(self._young), 0.0)
        force, most = force_noise(model, noise, young, self._interval), most_force_noise(model)
        if force <= most:
            return ""
        return (
            f"the poses are too noisy for contact: {1e3 * noise:.1f} mm make {force:.2f} N at the tip; "
            f"allowed: {most:.2f} N"
        )
