"""Trajectories of a solve to return to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.ocp.solvers.memory.parts import Multipliers
from doorman.ocp.solvers.memory.workspace import Workspace

_SAME = 1e-5
"""Costs that differ by less, relative to 1 + |J|, are those of one minimum."""


@dataclass(frozen=True, eq=False)
class Kept:
    """A trajectory with its feedback and multipliers, to go on from later."""

    cost: float
    states: Array
    inputs: Array
    gains: Array
    multipliers: Multipliers

    @classmethod
    def of(cls, work: Workspace, cost: float) -> Kept:
        """The nominal trajectory, to keep."""
        return cls(
            cost, work.nominal.states.copy(), work.nominal.inputs.copy(), work.policy.gains.copy(),
            Multipliers(*(array.copy() for array in work.multipliers)),
        )  # fmt: skip

    @classmethod
    def guess_of(cls, work: Workspace, multipliers: Multipliers | None) -> Kept:
        """The first guess of the present solve, with the multipliers that were given and without feedback."""
        return cls(
            work.result.guess, work.guess.states.copy(), work.guess.inputs.copy(),
            np.zeros_like(work.policy.gains),
            multipliers or Multipliers(*(np.zeros_like(array) for array in work.multipliers)),
        )  # fmt: skip

    @property
    def dearest(self) -> float:
        """Largest multiplier of a row or bound."""
        return max(float(np.abs(array).max(initial=0.0)) for array in self.multipliers)

    def costs_as(self, other: Kept) -> bool:
        """Whether both are at the same minimum, judged by their costs."""
        return abs(self.cost - other.cost) <= _SAME * (1.0 + abs(other.cost))

    def put_back(self, work: Workspace) -> None:
        """Make it the nominal trajectory again."""
        np.copyto(work.nominal.states, self.states)
        np.copyto(work.nominal.inputs, self.inputs)
        np.copyto(work.policy.gains, self.gains)
        for source, target in zip(self.multipliers, work.multipliers, strict=True):
            np.copyto(target, source)
