"""Widest postures at one door angle: local optima from many starting points, without chance from one call to the next."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.postures.minimax import minimise_largest
from doorman.postures.room import Room

YAW = 2
"""Index of the heading in x."""

_SAMPLES = 2000
_STARTS = 5
"""Samples that a search starts from."""
_APART = 0.5
"""Distance between them [rad]."""
_SAME = 0.02
"""Nearer postures are one [rad]."""
_NEAR_NORMAL = 0.6
"""Half of the samples look along the leaf's normal within this, the others anywhere [rad]."""
_SMALLEST_GAIN = 1e-4
"""Least gain of width that a step of the search must promise [m]."""
_DECIMALS = 4
"""Decimals of a posture that is found [rad]: what is printed is what is flown."""


class Found(NamedTuple):
    """A posture and its width."""

    state: Array
    """x = [Φ, α, 0, H], shape (5 + n,)."""
    width: float
    """Least of `Room.distances`."""


def widest(room: Room, state: Array, free: NDArray[np.int64]) -> Found:
    """Locally widest posture."""
    lower, upper = _bounds(room, state, free)

    def moved(point: Array) -> Array:
        posture = state.copy()
        posture[free] = point
        return posture

    point, _ = minimise_largest(
        lambda point: -room.distances(moved(point)), lambda point: -room.slopes(moved(point))[:, free],
        np.clip(state[free], lower, upper), lower, upper, _SMALLEST_GAIN,
    )  # fmt: skip
    best = moved(np.clip(point.round(_DECIMALS) + 0.0, lower, upper))  # and −0 is 0
    normal = room.heading(state)
    if YAW in free:
        best[YAW] = round(normal + math.remainder(float(best[YAW]) - normal, 2.0 * math.pi), _DECIMALS) + 0.0
    return Found(best, room.width(best))


def local_optima(room: Room, state: Array, free: NDArray[np.int64], starts: Iterable[Array] = ()) -> list[Found]:
    """Widest postures at a state's door angle, from given starting points and from the best of many samples."""
    points = (*starts, *_best_samples(room, state, free))
    return different([widest(room, pinned(start, state, free), free) for start in points])


def pinned(start: Array, state: Array, free: NDArray[np.int64]) -> Array:
    """A posture whose entries that may not change are those of another."""
    other = state.copy()
    other[free] = start[free]
    return other


def different(found: Iterable[Found]) -> list[Found]:
    """Postures that are not nearly those of others, the widest first."""
    chosen: list[Found] = []
    for one in sorted(found, key=lambda one: -one.width):
        if all(np.abs(one.state - other.state).max() > _SAME for other in chosen):
            chosen.append(one)
    return chosen


def _best_samples(room: Room, state: Array, free: NDArray[np.int64]) -> list[Array]:
    """The widest of many random postures, each apart from the wider ones."""
    generator = np.random.default_rng(0)
    lower, upper = _bounds(room, state, free)
    yaw, normal, half = free == YAW, room.heading(state), _SAMPLES // 2
    lower[yaw], upper[yaw] = normal - math.pi, normal + math.pi
    points = generator.uniform(lower, upper, (_SAMPLES, len(free)))
    points[:half, yaw] = generator.uniform(normal - _NEAR_NORMAL, normal + _NEAR_NORMAL, (half, int(yaw.sum())))
    states = np.tile(state, (_SAMPLES, 1))
    states[:, free] = points
    chosen: list[Array] = []
    for k in np.argsort(-room.rough_widths(states), kind="stable"):
        if all(np.linalg.norm(states[k] - other) > _APART for other in chosen):
            chosen.append(states[k])
        if len(chosen) == _STARTS:
            break
    return chosen


def joint_bounds(vehicle: Vehicle) -> tuple[Array, Array]:
    """Bounds of the arm's angles; a joint without limits turns by half a turn at most."""
    lower, upper = vehicle.lower_limits, vehicle.upper_limits
    return np.where(np.isfinite(lower), lower, -math.pi), np.where(np.isfinite(upper), upper, math.pi)


def _bounds(room: Room, state: Array, free: NDArray[np.int64]) -> tuple[Array, Array]:
    """Lower and upper bounds of the free entries."""
    lower, upper = np.full(len(state), -np.inf), np.full(len(state), np.inf)
    lower[5:], upper[5:] = joint_bounds(room.vehicle)
    return lower[free], upper[free]
