"""Set points of the attitude on their way through the dead time of the onboard loop."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class LateAttitude:
    """Each set point acts so many physics steps after it was given; the one before holds meanwhile.

    Args:
        delay: Number of steps.
    """

    def __init__(self, delay: int) -> None:
        self._delay = delay
        self._on_the_way: deque[tuple[int, Array]] = deque()

    def give(self, step: int, attitude: Array) -> None:
        """Take in a set point, as a quaternion, shape (4,)."""
        self._on_the_way.append((step + self._delay, attitude))

    def shifted(self, steps: int) -> LateAttitude:
        """The same on its way, with times that begin so many steps later."""
        other = LateAttitude(self._delay)
        other._on_the_way.extend((due - steps, attitude) for due, attitude in self._on_the_way)
        return other

    def act(self, step: int, acting: Array, most: int) -> int:
        """Let what is due act, and say for how many steps, at most, nothing else does."""
        waiting = self._on_the_way
        while waiting and waiting[0][0] <= step:
            acting[:] = waiting.popleft()[1]
        return min(waiting[0][0] - step, most) if waiting else most
