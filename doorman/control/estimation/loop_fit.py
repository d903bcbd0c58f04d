r"""Lag, dead time and shape of the attitude loop from what roll and pitch did after known commands, by least squares.

.. math::
    \min_{\tau, \varrho, d, b}\ \sum_t \big(\phi(t) - b - \phi_{\tau\varrho}(t - d)\big)^2

with :math:`\phi_{\tau\varrho}` the answer of `AttitudeLoop` of lag τ and shape ϱ to the commands: a bank of loops runs along with
the flight, and each tick compares what is seen with what each of them had a dead time ago. Both axes have one shape. The
deviations follow from the curvature of the sum.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.dynamics.attitude_loop import USUAL_RATIO, AttitudeLoop

_LAGS = np.geomspace(0.015, 0.6, 24)
"""Lags of the bank's loops [s]."""
_RATIOS = (USUAL_RATIO, 2.2, 1.75, 1.4, 1.1, 0.85)
"""Their shapes, the usual one first: steps overshoot by 1 to 20 %."""
_SURE = 8.0
"""Log-likelihood by which another shape must be better than the usual one: chance makes 2."""
_DELAYS = 0.01 * np.arange(21)
"""[s]."""
_LATENESSES = 0.002 * np.arange(31)
"""Latenesses of the body rates [s]."""
_COARSE = 0.4
"""Longest step of the bank, as a share of the quickest loop's time constant [1]."""
_CELL = 1.0 / math.sqrt(12.0)
"""Deviation of what is spread evenly over a cell of the grid, as a share of its width."""


@dataclass(frozen=True)
class MeasuredLoop:
    """Lag and dead time of roll and of pitch with their deviations, shape (2,) each [s]."""

    lag: Array
    dead_time: Array
    lag_deviation: Array
    dead_time_deviation: Array
    explained: Array
    """Share of what roll and pitch did that the fit explains, shape (2,)."""
    ratio: float = USUAL_RATIO
    """ϱ of both axes [1]."""

    @property
    def loop(self) -> AttitudeLoop:
        """One loop for both axes: their mean."""
        return AttitudeLoop(float(self.lag.mean()), float(self.dead_time.mean()), ratio=self.ratio)


class LoopFit:
    """Takes in commands and what was seen, tick by tick, for a longest time [s] at a rate [1/s]."""

    def __init__(self, duration: float, rate: float) -> None:
        most = math.ceil(1.5 * duration * rate) + 2
        loops = [AttitudeLoop(float(lag), ratio=ratio) for ratio in _RATIOS for lag in _LAGS]
        self._times, self._answers = np.zeros(most), np.zeros((most, len(loops), 2))
        self._count = self._compared = 0
        self._gain = np.array([[loop.gain] for loop in loops])
        self._rate_gain = np.array([[loop.rate_gain] for loop in loops])
        self._rates, self._commanded = np.zeros((len(loops), 2)), np.zeros(2)
        self._off, self._square = np.zeros((2, len(_DELAYS), len(loops), 2))
        self._seen, self._seen_square, self._first = np.zeros(2), np.zeros(2), np.zeros(2)
        self._poses = 0
        self._pose_time = math.nan

    def note(self, now: float, commanded: Array, seen: Array, pose_time: float) -> None:
        """Take in roll and pitch that are seen now, and those that are commanded from now on."""
        k = self._count
        if k == len(self._times):
            return
        if k == 0:
            self._answers[0], self._first = seen, seen.copy()
        else:
            self._answers[k] = self._advanced(self._answers[k - 1], now - float(self._times[k - 1]))
        self._times[k], self._commanded = now, commanded.copy()
        self._count = k + 1
        if now - float(self._times[0]) < _DELAYS[-1]:
            return
        rows = np.searchsorted(self._times[: k + 1], now - _DELAYS + 1e-6, side="right") - 1
        off = seen - self._answers[rows]
        self._off += off
        self._square += off * off
        self._seen += seen - self._first
        self._seen_square += (seen - self._first) ** 2
        self._compared += 1
        if pose_time != self._pose_time:
            self._poses, self._pose_time = self._poses + 1, pose_time

    def _advanced(self, tilt: Array, time_step: float) -> Array:
        """Answer of every loop a tick later."""
        count = max(1, math.ceil(time_step * float(self._rate_gain[0, 0]) / _COARSE))
        step = time_step / count
        for _ in range(count):
            self._rates += step * self._rate_gain * (self._gain * (self._commanded - tilt) - self._rates)
            tilt = tilt + step * self._rates
        return tilt

    def fitted(self) -> MeasuredLoop | None:
        """The loop of each axis; None before anything was compared."""
        if self._poses < 3:
            return None
        n = self._compared
        spread = self._square / n - (self._off / n) ** 2
        moved = self._seen_square / n - (self._seen / n) ** 2
        shapes = np.maximum(spread, 1e-12).reshape(len(_DELAYS), len(_RATIOS), len(_LAGS), 2)
        likelihood = -0.5 * self._poses * np.log(shapes.min(axis=(0, 2))).sum(axis=1)
        best = int(likelihood.argmax())
        best = best if likelihood[best] > likelihood[0] + _SURE else 0
        rows = [_least(shapes[:, best, :, axis], self._poses) for axis in (0, 1)]
        lag, dead, lag_deviation, dead_deviation, least = np.array(rows).T
        explained = 1.0 - least / np.maximum(moved, 1e-12)
        return MeasuredLoop(lag, dead, lag_deviation, dead_deviation, explained, _RATIOS[best])


def lateness(pose_times: Array, attitudes: Array, times: Array, rates: Array) -> float:
    r"""How much later than the poses' attitudes the body rates come [s].

    .. math:: \min_\theta\ \sum_k \big|\dot\phi(t_k) - \omega(t_k + \theta)\big|^2

    Args:
        pose_times: When the attitudes were true, shape (k,) [s].
        attitudes: Roll and pitch then, shape (k, 2) [rad].
        times: When the rates came, shape (m,) [s].
        rates: About the body's x and y axis, shape (m, 2) [rad/s].
    """
    turning = (attitudes[2:] - attitudes[:-2]) / (pose_times[2:] - pose_times[:-2])[:, None]
    off = [
        sum(
            float(np.square(np.interp(pose_times[1:-1] + late, times, rates[:, i]) - turning[:, i]).mean())
            for i in (0, 1)
        )
        for late in _LATENESSES
    ]
    return float(_LATENESSES[int(np.argmin(off))])


def _least(spread: Array, count: int) -> tuple[float, float, float, float, float]:
    """Lag, dead time and their deviations at the least of a table of mean squares, by a parabola through its neighbours."""
    row, column = np.unravel_index(int(spread.argmin()), spread.shape)
    i = min(max(int(row), 1), spread.shape[0] - 2)
    j = min(max(int(column), 1), spread.shape[1] - 2)
    near = spread[i - 1 : i + 2, j - 1 : j + 2]
    slope = 0.5 * np.array([near[2, 1] - near[0, 1], near[1, 2] - near[1, 0]])
    mixed = 0.25 * (near[2, 2] - near[2, 0] - near[0, 2] + near[0, 0])
    bend = np.array([
        [near[2, 1] - 2.0 * near[1, 1] + near[0, 1], mixed], [mixed, near[1, 2] - 2.0 * near[1, 1] + near[1, 0]]
    ])  # fmt: skip
    width = np.array([_DELAYS[1], _LAGS[j] * math.log(_LAGS[1] / _LAGS[0])])
    least = max(float(spread.min()), 1e-12)
    try:
        step, covariance = np.clip(-np.linalg.solve(bend, slope), -1.0, 1.0), 2.0 * least / count * np.linalg.inv(bend)
    except np.linalg.LinAlgError:
        step, covariance = np.zeros(2), np.eye(2)
    deviation = width * np.sqrt(np.clip(covariance.diagonal(), 0.0, 100.0) + (0.3 * _CELL) ** 2)
    dead = max(float(_DELAYS[i] + step[0] * width[0]), 0.0)
    lag = float(_LAGS[j] * (_LAGS[1] / _LAGS[0]) ** step[1])
    return lag, dead, float(deviation[1]), float(deviation[0]), least
