"""What acts on the vehicle at any time of the last half second: rotors behind their commands, gyroscope, arm, attitude.

The gyroscope is not late, and poses are. It carries the attitude from pose to pose; the poses correct it.
"""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.estimation.leaf.kernels.acting_step import (
    ARM,
    ATTITUDE,
    FORCE,
    LATE,
    MEMORY,
    POSED,
    carried,
    find_inputs,
    note_tick,
)
from doorman.signals import Measurement

_KEPT = 1024
"""Ticks that are kept at least: half a second at the fastest controller."""


class Acting:
    """Ring of ticks, and inputs as `LeafMotion` takes them; from the rotors' first force, (3,), body frame [N], and yaw [rad]."""

    def __init__(self, n_arm: int, force: Array, yaw: float) -> None:
        self._times, self._rows = np.zeros(2 * _KEPT), np.zeros((2 * _KEPT, ARM + 2 * n_arm))
        self._memory = np.zeros(MEMORY)
        self._memory[FORCE:ATTITUDE], self._memory[ATTITUDE + 2], self._memory[POSED] = force, yaw, math.nan
        self._inputs = np.zeros(12 + 2 * n_arm)
        self._seen = np.zeros(6 + 2 * n_arm)
        self._compile()

    def _compile(self) -> None:
        """Nothing compiles in flight."""
        note_tick(self._times, self._rows, self._memory.copy(), 0.0, self._seen, 0.0)
        find_inputs(self._times, self._rows, self._memory.copy(), 0.0, np.zeros(3), self._inputs)

    def are_late(self, lateness: float) -> None:
        """Say how much later than the poses' attitudes the body rates come, by their filter and their link [s]."""
        self._memory[LATE] = lateness

    def note(self, measured: Measurement, force: Array) -> None:
        """Take in a tick, and what was commanded since the tick before, shape (3,), body frame [N]."""
        age = 0.0 if measured.arm_time is None else max(measured.time - measured.arm_time, 0.0)
        np.concatenate((measured.body_rates, measured.arm_angles, measured.arm_rates, force), out=self._seen)
        note_tick(self._times, self._rows, self._memory, measured.time, self._seen, age)

    def at(self, time: float, attitude: Array) -> Array:
        """Inputs at the time of a pose, which comes with an attitude, shape (m,)."""
        find_inputs(self._times, self._rows, self._memory, time, np.array(attitude), self._inputs)
        return self._inputs.copy()

    def carried(self, time: float) -> Array:
        """Φ that the gyroscope has carried on from the last pose, without jumps, shape (3,) [rad]."""
        return np.array([carried(self._times, self._rows, self._memory, time, i) for i in range(3)])

    @property
    def ring(self) -> tuple[Array, Array, Array]:
        """Times, rows and memory, as kernels read them."""
        return self._times, self._rows, self._memory
