"""Ways between postures inside the constraints: along the swing of the door, and across at one door angle."""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.postures.room import Room
from doorman.postures.search import YAW, widest

_SPACING = math.radians(7.5)
_ACROSS = np.linspace(0.0, 1.0, 15)


def turned(room: Room, state: Array, door_angle: float) -> Array:
    """The posture relative to the leaf, at another door angle."""
    other = state.copy()
    other[YAW] -= room.heading(state)
    other[3] = door_angle
    other[YAW] += room.heading(other)
    return other


def follow(room: Room, state: Array, door_angle: float) -> tuple[Array, bool]:
    """Follow the locally widest posture along the swing."""
    free = np.array([YAW, *range(5, len(state))])
    clear = bool(room.constraints(state).max() <= 0.0)
    start = float(state[3])
    for angle in np.linspace(start, door_angle, max(2, math.ceil(abs(door_angle - start) / _SPACING) + 1)):
        state = widest(room, turned(room, state, float(angle)), free).state
        clear = clear and bool(room.constraints(state).max() <= 0.0)
    return state, clear


def straight_way_is_clear(room: Room, first: Array, last: Array) -> bool:
    """Whether all postures between two keep the constraints, as heading and arm go straight from one to the other."""
    return bool(room.constraints_along(first + np.outer(_ACROSS, last - first)).max() <= 0.0)
