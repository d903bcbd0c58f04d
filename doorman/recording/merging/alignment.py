r"""Offset between two clocks by the body rates that both have recorded.

With the rates ω of the run and ω' of the log on one fine grid, the offset is where their correlation

.. math::
    \rho(\tau) = \frac{\sum_t \omega(t + \tau) \cdot \omega'(t)}{\sqrt{\sum_t |\omega(t + \tau)|^2 \sum_t |\omega'(t)|^2}}

is largest, over stretches of at least half of the shorter one. Between grid points it is the vertex of the parabola through the
three highest. Parts of the stretch find it again, each by itself; how far they disagree is the deviation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.bounds import LONGEST
from doorman.exceptions import RecordingError

GRID = 0.005
"""Step of the grid of both rates [s]."""


@dataclass(frozen=True)
class Alignment:
    """How a log's clock lies on a run's: run = log + offset."""

    offset: float
    """[s]."""
    deviation: float
    """Standard deviation of the offset [s]; NaN where nothing tells it."""
    by: str
    """Its source, in words."""

    def to_run(self, time: Array) -> Array:
        """Times of the log on the run's clock.

        Args:
            time: Shape (m,) [s].

        Returns:
            Shape (m,) [s].
        """
        return time + self.offset


def align_by_rates(
    run_time: Array,
    run_rates: Array,
    log_time: Array,
    log_rates: Array,
    *,
    least: float = 0.6,
    rival: float = 0.95,
    apart: float = 0.5,
) -> Alignment:
    """Align by the highest correlation: at least so much, and so far apart [s] none of that share of it."""
    run_start, run = _on_grid(run_time, run_rates, "the run")
    log_start, log = _on_grid(log_time, log_rates, "the log")
    lags, correlation = _correlation(run, log)
    best = int(np.argmax(correlation))
    if correlation[best] < least:
        raise RecordingError("the rates of run and log do not agree", field="correlation",
                             given=round(float(correlation[best]), 3),
                             allowed=f"at least {least:g}; a log of the same flight, or --offset")  # fmt: skip
    elsewhere = np.where(np.abs(lags - lags[best]) * GRID > apart, correlation, -1.0)
    if elsewhere.max() > rival * correlation[best]:
        raise RecordingError("the rates of run and log agree at several places", field="offset",
                             given=f"{GRID * lags[best] + run_start - log_start:.3f} and "
                                   f"{GRID * lags[int(np.argmax(elsewhere))] + run_start - log_start:.3f} s",
                             allowed="a longer flight, or --offset")  # fmt: skip
    fine = GRID * (lags[best] + _vertex(correlation, best))
    deviation = _deviation(run, log, int(lags[best]), fine)
    return Alignment(run_start - log_start + fine, deviation, "cross-correlation of rates")


def _on_grid(time: Array, rates: Array, name: str, *, least: float = 2.0, gap: float = 1.0) -> tuple[float, Array]:
    """Rates on the grid from their first time on, without their mean, 0 in gaps [s]; what is not finite is left out."""
    good = np.isfinite(time) & np.isfinite(rates).all(axis=1)
    time, rates = time[good], rates[good]
    if len(time) < 2 or time[-1] - time[0] < least:
        raise RecordingError(f"the body rates of {name} are too short", given=f"{np.ptp(time) if len(time) else 0.0:.1f} s",
                             allowed=f"at least {least:g} s, or --offset")  # fmt: skip
    if time[-1] - time[0] > 2.0 * LONGEST:
        raise RecordingError(f"the body rates of {name} are too long", given=f"{time[-1] - time[0]:g} s",
                             allowed=f"up to {2.0 * LONGEST:g} s, or --offset")  # fmt: skip
    grid = np.arange(time[0], time[-1], GRID)
    placed = np.stack([np.interp(grid, time, rates[:, axis]) for axis in range(3)], axis=1)
    placed = np.stack([np.convolve(column, _kernel(len(grid)), "same") for column in placed.T], axis=1)
    seen = np.diff(time)[np.minimum(np.searchsorted(time, grid, side="right"), len(time) - 1) - 1] <= gap
    placed = np.where(seen[:, None], placed - placed[seen].mean(axis=0) if seen.any() else 0.0, 0.0)
    if not np.abs(placed).max() > 1e-6:
        raise RecordingError(f"the body of {name} does not turn", allowed="a flight, or --offset")
    return float(time[0]), placed


def _kernel(length: int, deviation: float = 0.03) -> Array:
    """Bell curve that leaves motions up to 5 Hz, and takes what gyroscopes add; never longer than the rates."""
    reach = min(round(3.0 * deviation / GRID), (length - 1) // 2)
    bell = np.exp(-0.5 * (np.arange(-reach, reach + 1) * GRID / deviation) ** 2)
    return np.asarray(bell / bell.sum())


def _correlation(run: Array, log: Array) -> tuple[NDArray[np.int64], Array]:
    """Correlation by lag in grid steps: run[i + lag] lies on log[i]."""
    size = 1 << int(np.ceil(np.log2(len(run) + len(log))))
    cross = sum(_product(run[:, axis], log[:, axis], size) for axis in range(3))
    ones = np.ones(len(run)), np.ones(len(log))
    run_power = _product(np.sum(run**2, axis=1), ones[1], size)
    log_power = _product(ones[0], np.sum(log**2, axis=1), size)
    overlap = _product(*ones, size)
    lags = np.arange(-(len(log) - 1), len(run))
    least = 0.5 * min(len(run), len(log))
    power = np.sqrt(np.maximum(run_power, 1e-12) * np.maximum(log_power, 1e-12))
    good = (overlap[lags] > least - 0.5) & (power[lags] > 1e-3 * power.max())
    return lags, np.where(good, np.asarray(cross)[lags] / power[lags], -1.0)


def _product(run: Array, log: Array, size: int) -> Array:
    """Sum of run[i + lag] log[i] by lag, negative lags from the end."""
    return np.fft.irfft(np.fft.rfft(run, size) * np.conj(np.fft.rfft(log, size)), size)


def _vertex(values: Array, best: int) -> float:
    """Vertex of the parabola through a maximum and its neighbours, in steps from it."""
    if not 0 < best < len(values) - 1 or min(values[best - 1], values[best + 1]) <= -1.0:
        return 0.0
    left, middle, right = values[best - 1 : best + 2]
    bend = left - 2.0 * middle + right
    return float(0.5 * (left - right) / bend) if bend < 0.0 else 0.0


def _deviation(run: Array, log: Array, lag: int, whole: float, *, parts: int = 6, around: float = 0.1) -> float:
    """How far parts of the stretch disagree with the whole around its offset; parts that are rather still say nothing [s]."""
    start, end = max(0, -lag), min(len(log), len(run) - lag)
    reach = round(around / GRID)
    power = np.sum(log[start:end] ** 2, axis=1).mean()
    found = []
    for part in np.array_split(np.arange(start, end), parts):
        part = part[(part + lag - reach >= 0) & (part + lag + reach < len(run))]
        if len(part) < 4 * reach or np.sum(log[part] ** 2, axis=1).mean() < 0.25 * power:
            continue
        near = np.array([np.sum(run[part + lag + step] * log[part]) for step in range(-reach, reach + 1)])
        near /= np.sqrt([np.sum(run[part + lag + step] ** 2) + 1e-12 for step in range(-reach, reach + 1)])
        best = int(np.argmax(near))
        found.append(GRID * (lag + best - reach + _vertex(near, best)) - whole)
    if len(found) < 2:
        return float("nan")
    return float(np.sqrt(np.sum(np.square(found)) / (len(found) - 1) / len(found)))
