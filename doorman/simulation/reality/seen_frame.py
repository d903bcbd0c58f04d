r"""The frame in which poses are seen, which jumps, slides away and turns, and swaps of markers, by which all poses are off.

.. math::
    P_{seen} = R_z(\omega t)\,P + J + v\,t\,u, \qquad \psi_{seen} = \psi + \omega t

with J drawn anew at every jump, of deviation `jump` on every axis, the speed `drift` v in a horizontal direction u drawn by
chance, and the `turn_rate` ω. A motion capture jumps so when it is recalibrated or takes one marker for another; odometry drifts
and turns.
"""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.scenario import SensorsSection
from doorman.simulation.chance import Dropouts, Jumps

_FRAME = 3
"""Stream of random numbers of a seed that moves the frame."""
_TIMES, _SIZES = 9, 10
"""Streams of one seed's random numbers that make times and directions."""


class SeenFrame:
    """Frame in which the poses of one flight are seen."""

    def __init__(self, section: SensorsSection, seed: int) -> None:
        self._section = section
        self._jumps = Jumps(section.jump_rate, (seed, _FRAME))
        towards = self._jumps.generator.uniform(-math.pi, math.pi)
        self._slides = section.drift * np.array([math.cos(towards), math.sin(towards), 0.0])
        self._jumped = np.zeros(3)
        self._turned, self._cosine, self._sine, self._moved = 0.0, 1.0, 0.0, np.zeros(3)

    def advance(self, time: float) -> None:
        """Move the frame."""
        for _ in range(self._jumps.since(time)):
            self._jumped = self._section.jump * self._jumps.generator.standard_normal(3)
        self._turned = self._section.turn_rate * time
        self._cosine, self._sine = math.cos(self._turned), math.sin(self._turned)
        self._moved = self._jumped + time * self._slides

    def position(self, position: Array) -> Array:
        """A position as it is seen."""
        return self.velocity(position) + self._moved

    def velocity(self, velocity: Array) -> Array:
        """A velocity as it is seen."""
        x, y, z = velocity
        return np.array([self._cosine * x - self._sine * y, self._sine * x + self._cosine * y, z])

    def attitude(self, attitude: Array) -> Array:
        """An attitude as it is seen."""
        return np.asarray(attitude + np.array([0.0, 0.0, self._turned]))


def seen_frame(section: SensorsSection, seed: int) -> SeenFrame | None:
    """The frame, or None where it is the world's."""
    moves = (section.jump_rate > 0.0 and section.jump > 0.0) or section.drift > 0.0 or section.turn_rate != 0.0
    return SeenFrame(section, seed) if moves else None


class Swaps:
    """Swaps of one flight; the seed is that of times and directions."""

    def __init__(self, section: SensorsSection, seed: int) -> None:
        self._section, self._generator = section, np.random.default_rng([seed, _SIZES])
        self._times = Dropouts(section.swap_rate, section.swap_duration, [seed, _TIMES])
        self._off: Array | None = None

    def off(self, time: float) -> Array:
        """By how much position [m] and attitude [rad] are off now, shape (6,); times must not decrease."""
        if not self._times.lost(time):
            self._off = None
            return np.zeros(6)
        if self._off is None:
            moved, turned = (each / np.linalg.norm(each) for each in self._generator.standard_normal((2, 3)))
            self._off = np.concatenate((self._section.swap * moved, self._section.swap_turn * turned))
        return self._off
