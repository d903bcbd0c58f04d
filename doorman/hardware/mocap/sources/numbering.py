r"""Frame numbers for cameras whose client tells none: a frame is numbered by its time, of arrival or as stamped.

.. math::
    k = \operatorname{round}\left(\frac{t - t_0}{T} - c\right)

c follows what is left, so that a true rate a little off the nominal one skips no number. A frame that comes in the period of the
one before gets no number: it waited somewhere, and its time is not known.

A stamp that does not fit the others is numbered all the same: the receiver, which knows when the frame came, judges it. A clock
that was set back alone would look like a delay to it. `BACK` frames in a row that are older than the newest therefore get numbers
far from all before: a stream that begins anew.
"""

from __future__ import annotations

import math

BACK = 3
"""Frames in a row behind the newest that show a clock that was set back; fewer are strays."""
_FAR = 1 << 30
"""Distance of new numbers from the old ones, a quarter of all that packets can hold."""
_FOLLOWED = 0.02
"""Share of the rest by which c is corrected a frame."""


class ArrivalNumbers:
    """Numbers of one stream of frames."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._start = self._correction = 0.0
        self._first = self._behind = 0
        self._newest = self._before = -math.inf
        self._last: int | None = None

    def number(self, time: float, stamped: bool = False) -> int | None:
        """Number of a frame."""
        if self._last is None:
            self._start = time
        again = stamped and time == self._newest
        self._follow(time)
        periods = (time - self._start) * self._rate - self._correction
        number = self._first + round(periods)
        if number == self._last and not again:
            return None
        self._correction += _FOLLOWED * (periods - round(periods))
        self._last = number
        return number

    def _follow(self, time: float) -> None:
        """See whether the clock was set back; a newest time that the next one does not reach was a stray ahead."""
        if time > self._newest:
            self._before, self._newest, self._behind = self._newest, time, 0
        elif time > self._before:
            self._newest, self._behind = time, 0
        else:
            self._behind += 1
            if self._behind == BACK:
                self._start, self._first, self._correction = time, self._first + _FAR, 0.0
                self._newest, self._before, self._behind = time, -math.inf, 0
