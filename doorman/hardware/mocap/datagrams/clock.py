r"""When frames were taken, from their numbers: packets carry no time, and arrive late in ways that change.

Frame k arrives at the earliest at :math:`l(k) = b + k T`, where T is the period, nominal or as learnt. b follows the quickest
packets: it falls at once to where two packets in a row say that it is, and rises only as slowly as crystals drift apart, and
only while packets are hardly late. So a delay that sets in or grows, however long it lasts, is never taken for the new normal.
The frame was taken at :math:`\min(l(k), \text{arrival}) - \text{latency}`.

A clock that a time server slews would look like a queue that grows: times are those of the raw clock, which none does.
"""

from __future__ import annotations

_DRIFT = 1e-4
"""Largest drift of two crystals against each other [s/s]."""
_DRIFTED = 0.01
"""Lateness that may still be drift [s]."""


class FrameClock:
    """Maps frame numbers to this computer's raw clock."""

    def __init__(self, rate: float, latency: float) -> None:
        self._nominal = 1.0 / rate
        self._period = self._nominal
        self._latency = latency
        self._base = 0.0
        self._frame = 0
        self._arrival = 0.0
        self._previous = 0.0

    def start(self, frame: int, arrival: float) -> None:
        """Begin anew: this frame counts as in time."""
        self._base, self._frame, self._arrival, self._previous = arrival, frame, arrival, 0.0

    def lateness(self, frame: int, arrival: float) -> float:
        """Time between the earliest possible and the actual arrival of a frame; negative if it is early [s]."""
        return arrival - self._base - (frame - self._frame) * self._period

    def observe(self, frame: int, arrival: float) -> float:
        """Take in the arrival of a frame."""
        late = self.lateness(frame, arrival)
        floor = max(late, self._previous)  # a single packet with a wrong number does not move the clock
        if floor < 0.0:
            moved = floor
        elif floor <= _DRIFTED:
            moved = min(floor, _DRIFT * (arrival - self._arrival))
        else:
            moved = 0.0
        self._base += (frame - self._frame) * self._period + moved
        self._frame, self._arrival, self._previous = frame, arrival, late - moved
        return max(late - moved, 0.0)

    def time_of(self, frame: int, arrival: float) -> float:
        """When a frame was taken."""
        return arrival - max(self.lateness(frame, arrival), 0.0) - self._latency

    def follow(self, deviation: float) -> None:
        """Take over a small deviation of the rate from its nominal value."""
        self._period = self._nominal * (1.0 + deviation)
