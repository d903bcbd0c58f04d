r"""Frame numbers for cameras whose client tells none: a frame is numbered by when it comes.

.. math::
    k = \operatorname{round}\left(\frac{t - t_0}{T} - c\right)

c follows what is left, so that a true rate a little off the nominal one skips no number. A frame that comes in the period of the
one before gets no number: it waited somewhere, and its time is not known.
"""

from __future__ import annotations

_FOLLOWED = 0.02
"""Share of the rest by which c is corrected a frame."""


class ArrivalNumbers:
    """Numbers of one stream of frames.

    Args:
        rate: Nominal frames per second [1/s].
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._start: float | None = None
        self._correction = 0.0
        self._last = 0

    def number(self, arrival: float) -> int | None:
        """Number of a frame.

        Args:
            arrival: By a clock that nobody sets, not before the last [s].

        Returns:
            Larger than all before; None for a frame without a time.
        """
        if self._start is None:
            self._start = arrival
            return self._last
        periods = (arrival - self._start) * self._rate - self._correction
        number = round(periods)
        if number <= self._last:
            return None
        self._correction += _FOLLOWED * (periods - number)
        self._last = number
        return number
