"""What acts on the vehicle at any time of the last half second: rotors behind their commands, gyroscope, arm, attitude.

The gyroscope is not late, and poses are. It carries the attitude from pose to pose; the poses correct it.
"""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.compilation import entry
from doorman.estimation.leaf.kernels.acting_step import (
    ActingMemory,
    Inputs,
    Ring,
    Tick,
    carried,
    find_inputs,
    note_tick,
)
from doorman.numba_types.handles import held
from doorman.signals import Measurement

_KEPT = 1024
"""Ticks that are kept at least: half a second at the fastest controller."""


class Acting:
    """Ring of ticks, and inputs as `LeafMotion` takes them; from the rotors' first force, (3,), body frame [N], and yaw [rad]."""

    def __init__(self, n_arm: int, force: Array, yaw: float) -> None:
        memory = ActingMemory(force=force, attitude=(0.0, 0.0, yaw), posed=math.nan)
        times, threes, arms = np.zeros(2 * _KEPT), (2 * _KEPT, 3), (2 * _KEPT, n_arm)
        self.ring = Ring(memory, times, np.zeros(threes), np.zeros(threes), np.zeros(arms), np.zeros(arms))
        """Its arrays are written to."""
        self._memory, self.tick = memory, Tick(*(np.zeros(size) for size in (3, n_arm, n_arm, 3)))
        self._ring, self._seen = held(self.ring), held(self.tick)
        self._inputs, self._attitude = np.zeros(12 + 2 * n_arm), np.zeros(3)
        self._parts = held(Inputs.of(self._inputs))
        self._note = entry(note_tick, self._ring, self._seen, 0.0, 0.0)
        self._find = entry(find_inputs, self._ring, 0.0, self._attitude, self._parts)

    def are_late(self, lateness: float) -> None:
        """Say how much later than the poses' attitudes the body rates come, by their filter and their link [s]."""
        self._memory.late = lateness

    def note(self, measured: Measurement, force: Array) -> None:
        """Take in a tick, and what was commanded since the tick before, shape (3,), body frame [N]."""
        age, tick = 0.0 if measured.arm_time is None else max(measured.time - measured.arm_time, 0.0), self.tick
        tick.body_rates[:], tick.force[:] = measured.body_rates, force
        tick.arm_angles[:], tick.arm_rates[:] = measured.arm_angles, measured.arm_rates
        self._note(self._ring, self._seen, measured.time, age)

    def at(self, time: float, attitude: Array) -> Array:
        """Inputs at the time of a pose, which comes with an attitude, shape (m,)."""
        self._attitude[:] = attitude
        self._find(self._ring, time, self._attitude, self._parts)
        return self._inputs.copy()

    def carried(self, time: float) -> Array:
        """Φ that the gyroscope has carried on from the last pose, without jumps, shape (3,) [rad]."""
        return np.array([carried(self._ring, time, i) for i in range(3)])
