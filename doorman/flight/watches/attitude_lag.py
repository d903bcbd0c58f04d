"""How far the attitude lags behind its setpoints: the price of a rate loop that is not tuned."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.recording import Recording

Array = NDArray[np.float64]

_PERIOD = 0.005
_LONGEST = 0.5
_LEAST_MOTION = 0.003
"""Standard deviation of the setpoints below which nothing can be told [rad]."""
_LEAST_TIME = 5.0
_LEAST_LIKENESS = 0.5
"""Correlation below which the two are strangers."""


def attitude_lag(asked_at: ArrayLike, asked: ArrayLike, seen_at: ArrayLike, seen: ArrayLike) -> float:
    """Delay at which roll and pitch resemble their setpoints most."""
    (given, asked), (got, seen) = _finite(asked_at, asked), _finite(seen_at, seen)
    if min(len(given), len(got)) < 2:
        return math.nan
    times = np.arange(max(given[0], got[0]), min(given[-1], got[-1]), _PERIOD)
    if len(times) * _PERIOD < _LEAST_TIME:
        return math.nan
    wanted, flown = (
        np.column_stack([np.interp(times, at, values[:, axis]) for axis in (0, 1)])
        for at, values in ((given, asked), (got, seen))
    )
    wanted, flown = wanted - wanted.mean(axis=0), flown - flown.mean(axis=0)
    if math.sqrt(float((wanted**2).mean())) < _LEAST_MOTION:
        return math.nan
    last = round(_LONGEST / _PERIOD)
    likeness = [_alike(wanted[: len(wanted) - step], flown[step:]) for step in range(last + 1)]
    best = int(np.argmax(likeness))
    return _PERIOD * best if best < last and likeness[best] > _LEAST_LIKENESS else math.nan


def recorded_lag(recording: Recording) -> float:
    """Lag in a flight by attitude setpoints that was recorded [s]; NaN if it shows none."""
    if not {"command", "measurement"} <= set(recording):
        return math.nan
    asked, seen = recording["command"], recording["measurement"]
    return attitude_lag(asked.time, asked["attitude"], seen.time, seen["attitude"])


def _finite(times: ArrayLike, values: ArrayLike) -> tuple[Array, Array]:
    at, rows = np.asarray(times, dtype=np.float64), np.asarray(values, dtype=np.float64)
    good = np.isfinite(rows).all(axis=1) & np.isfinite(at)
    return at[good], rows[good]


def _alike(first: Array, second: Array) -> float:
    power = math.sqrt(float((first**2).sum() * (second**2).sum()))
    return float((first * second).sum()) / power if power > 0.0 else 0.0
