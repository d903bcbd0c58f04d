"""What a door's URDF leaves open: where its joint is closed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.kinematics.doors.urdf.beside import Box

_NEAR = 0.15
"""Farthest gap between the leaf's free edge and the jamb that it closes at, as a share of its width."""
_STEPS = 180
"""Angles at which a joint's range is searched for jambs."""
_AT_END = 0.05
"""By which a closed door may be outside of its range [rad]."""
ROUNDED = 2e-3
"""By which files round a right angle, and the ends of a range [rad or m]."""


@dataclass(frozen=True)
class Closed:
    """Joint value at which a door is closed."""

    value: float
    """[rad or m]."""
    guessed: bool = False
    """Whether neither the scenario nor a jamb tells."""
    doubtful: bool = False
    """Whether the leaf meets a jamb there that need not be the one at which it is closed."""


def closed_value(limits: tuple[float, float], at_a_jamb: Callable[[float], bool], upright: bool = True) -> Closed:
    """Where a door is closed.

    The jamb at the leaf's free edge tells. Without one it is guessed: the end of the range at 0, else π/2 where the range of an
    upright door holds that, else the end nearer to 0.
    """
    lower, upper = limits
    at_zero = [end for end in limits if abs(end) <= _AT_END]
    ends = sorted(limits, key=abs)
    # a range ends where the door is shut
    beside = [end for end in limits if ROUNDED < abs(end - 0.5 * math.pi) <= _AT_END]
    likely = [
        value for value in (*at_zero, *beside, 0.5 * math.pi, 0.0, *ends) if lower - _AT_END <= value <= upper + _AT_END
    ]
    for value in likely:
        if at_a_jamb(value):
            return Closed(value)
    for value in (lower + (upper - lower) * k / _STEPS for k in range(1, _STEPS)):
        if at_a_jamb(value):
            return Closed(value, doubtful=True)
    return Closed(likely[0] if at_zero or (upright and likely[0] == 0.5 * math.pi) else ends[0], guessed=True)


def closed_near_zero(limits: tuple[float, float]) -> Closed:
    """Where a slide or a lever is closed: 0, or the end of the range that is nearer to it."""
    lower, upper = limits
    inside = lower + ROUNDED < 0.0 < upper - ROUNDED
    known = lower - ROUNDED < 0.0 < upper + ROUNDED
    return Closed(0.0 if inside else min(limits, key=abs), guessed=not known)


def meets(boxes: Iterable[Box], edge: Array, along: Array, width: float) -> bool:
    """Whether a box stands just beyond a leaf's free edge."""
    for box in boxes:
        gap = float(np.linalg.norm(np.maximum(np.abs(edge - box.center) - box.half, 0.0)))
        if gap <= _NEAR * width and float((box.center - edge) @ along) > 0.0:
            return True
    return False
