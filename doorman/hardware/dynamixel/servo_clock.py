r"""Proof of freshness by the servo's own clock: is an answer younger than the question?

Protocol 2.0 numbers nothing, so a late, repeated or frozen answer looks like the one that is awaited. Every answer carries the
servo's millisecond clock c. With h the computer's clock, the measurement lies between question and answer, so

.. math::
    c - h_\mathrm{received} \le o \le c - h_\mathrm{sent}

holds for the offset o of the clocks whenever the answer belongs to the question. The largest lower bound so far is kept; an
answer whose upper bound lies below it was measured before the question was sent. Answers that are too old only weaken their own
bound, so they cannot spoil it.
"""

from __future__ import annotations

import math

from doorman.hardware.dynamixel.wire.units import TICK_RANGE, TICK_UNIT

RESOLUTION = 2.0 * TICK_UNIT
"""Two readings of a clock of whole milliseconds [s]."""
DRIFT = 1e-2
"""Largest drift between the clocks: what a clock without a quartz may be off. An answer that comes late by d from some moment on
is told for about d / DRIFT, far longer than it takes to stop the arm."""


class ServoClock:
    """Bounds of the offset between a servo's clock and the computer's."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forget the offset, as after a restart of the servo."""
        self._tick: int | None = None
        self._clock = 0.0
        self._heard = 0.0
        self._bound = -math.inf
        self.runs = False  # whether the servo's clock was seen to advance; only then it proves anything

    def lateness(self, sent: float, received: float, tick: int) -> float:
        """How much older than the question an answer is at least."""
        clock = self._unwrap(received, tick)
        self._bound -= DRIFT * (received - self._heard)
        late = self._bound - (clock - sent) - RESOLUTION
        self._bound = max(self._bound, clock - received)
        self._heard = received
        return max(late, 0.0) if self.runs else 0.0

    def _unwrap(self, received: float, tick: int) -> float:
        """The servo's clock without the jumps to zero [s]: counted on from the last answer."""
        if self._tick is None:
            self._tick, self._heard = tick, received
        step = (tick - self._tick + TICK_RANGE // 2) % TICK_RANGE - TICK_RANGE // 2
        rounds = round((received - self._heard - step * TICK_UNIT) / (TICK_RANGE * TICK_UNIT))
        self.runs = self.runs or step != 0
        self._tick = tick
        self._clock += (step + rounds * TICK_RANGE) * TICK_UNIT
        return self._clock
