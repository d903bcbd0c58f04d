"""What a filter says of a measurement or a step."""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """Result of `Filter.measure` and `Filter.step`: the worst that happened, from 0 on.

    The filter goes on after all but `LOST` and `NOT_STARTED`, which `Filter.start` ends.
    """

    OK = 0
    REFUSED = 1
    """A measurement lies outside its gate under every hypothesis. It is not fused."""
    DROPPED = 2
    """A hypothesis' covariance lost its meaning. Its probability is 0 until the others switch to it."""
    TOO_OLD = 3
    """The measurement is older than the kept ticks, or than the start. It is not taken."""
    TOO_MANY = 4
    """More measurements than there is memory for. It is not taken."""
    CLOCK = 5
    """Time does not go on, or jumps by more than the longest step. Nothing is done."""
    NOT_FINITE = 6
    """A time, a measured value or an input is NaN or infinite. Nothing is done."""
    NOT_STARTED = 7
    """The filter has not been started, or was lost."""
    LOST = 8
    """No hypothesis is left with a meaningful covariance. The filter stops."""
