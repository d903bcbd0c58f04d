r"""Markers that the cameras take for others: for a while every pose is off by the same d.

A pose p that is farther from the last one than a vehicle can fly meanwhile begins a swap. With :math:`\hat p`, where it is
expected, :math:`d = p - \hat p`. A later pose is off by d or by nothing, whichever is nearer to what is expected:

.. math:: \lVert p - d - \hat p\rVert < \lVert p - \hat p\rVert .

A blow does not move the vehicle so fast. A frame that has moved for good passes for a swap until that has lasted too long.
"""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array


class Swapped:
    """Whether the cameras see other markers now: by a fastest speed [m/s], a gate in deviations, a longest swap [s]."""

    def __init__(self, fastest: float, gate: float, longest: float) -> None:
        self._fastest, self._gate, self._longest = fastest, gate, longest
        self._off, self._since, self._has_moved = np.zeros(3), 0.0, False
        self._last: Array | None = None
        self.now = False
        """Whether they do."""

    def undone(self, time: float, position: Array, expected: Array, passed: float, deviation: float) -> Array:
        """A pose as the right markers would give it, (3,) [m]; a frame that has moved for good is seen as it is."""
        off = position - expected
        most = max(self._fastest * passed, self._gate * deviation)
        far = _length(off) > most
        jumped = far and self._last is not None and _length(position - self._last) > most
        self._has_moved, self._last = self._has_moved and far, position
        if self.now:
            over, lasts = _length(off) < _length(off - self._off), time - self._since >= self._longest
            self.now, self._has_moved = not (over or lasts), lasts and not over
        elif far and jumped and not self._has_moved:
            self.now, self._off, self._since = True, off, time
        return position - self._off if self.now else position


def _length(vector: Array) -> float:
    return math.sqrt(vector.dot(vector))
