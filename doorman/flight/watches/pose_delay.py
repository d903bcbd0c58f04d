"""By how much poses are later than they are stamped, measured in flight against the autopilot, which feels every motion."""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.hardware.mocap import PoseSample
from doorman.hardware.pixhawk import VehicleSample

_STEP, _MOST = 0.002, 0.15
"""Resolution and largest size of a delay that is looked for, either way [s]."""
_LEAST_MOTION = 0.004
"""Standard deviation of roll and pitch below which no delay is found [rad]."""
_LEAST_LIKENESS = 0.8
"""Correlation below which cameras and autopilot are strangers."""
_ENOUGH_READINGS = 40


class PoseDelay:
    """Collects attitudes of cameras and autopilot, each with the time at which it was true as far as is known."""

    def __init__(self) -> None:
        self._seen: list[tuple[float, float, float]] = []
        self._felt: list[tuple[float, float, float]] = []

    def note(self, pose: PoseSample, state: VehicleSample) -> None:
        """Take in the newest of both; what it has seen before does not count."""
        pose = pose.origin or pose
        if pose.usable and (not self._seen or pose.time > self._seen[-1][0]):
            self._seen.append((pose.time, float(pose.attitude[0]), float(pose.attitude[1])))
        if math.isfinite(state.attitude_time) and (not self._felt or state.attitude_time > self._felt[-1][0]):
            self._felt.append((state.attitude_time, float(state.attitude[0]), float(state.attitude[1])))

    @property
    def delay(self) -> float:
        """By how much poses are later than their stamps say [s]; NaN where the vehicle did not move enough to tell."""
        if min(len(self._seen), len(self._felt)) < _ENOUGH_READINGS:
            return math.nan
        seen, felt = np.array(self._seen), np.array(self._felt)
        inside = (seen[:, 0] > felt[0, 0] + _MOST) & (seen[:, 0] < felt[-1, 0] - _MOST)
        times, angles = seen[inside, 0], seen[inside, 1:]
        if len(times) < _ENOUGH_READINGS or float(np.std(angles, axis=0).max()) < _LEAST_MOTION:
            return math.nan
        delays = np.arange(-_MOST, _MOST + 0.5 * _STEP, _STEP)
        likeness = [_alike(angles, _at(times - delay, felt)) for delay in delays]
        best = int(np.argmax(likeness))
        if likeness[best] < _LEAST_LIKENESS or best in (0, len(delays) - 1):
            return math.nan
        return float(delays[best])


def _at(times: Array, felt: Array) -> Array:
    return np.column_stack([np.interp(times, felt[:, 0], felt[:, axis]) for axis in (1, 2)])


def _alike(first: Array, second: Array) -> float:
    first, second = first - first.mean(axis=0), second - second.mean(axis=0)
    power = math.sqrt(float((first**2).sum() * (second**2).sum()))
    return float((first * second).sum()) / power if power > 0.0 else 0.0
