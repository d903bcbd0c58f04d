"""The interior-point search as solvers call it: its memory, and trajectories to return to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.numba_types.handles import held
from doorman.ocp.solvers.interior.iterate import search
from doorman.ocp.solvers.interior.memory import Interior
from doorman.ocp.solvers.parts import Multipliers
from doorman.ocp.solvers.workspace import Workspace

Array = NDArray[np.float64]

_SAME = 1e-5
"""Costs that differ by less, relative to 1 + |J|, are those of one minimum."""


class Searcher:
    """Interior-point search in the memory of a solver.

    Args:
        work: The solver's workspace.
    """

    def __init__(self, work: Workspace) -> None:
        self.memory = Interior.of(work)
        self._held = held(self.memory)

    def search(self, model: Any, work: Any, max_iterations: int, deadline: float) -> int:
        """Search from the nominal trajectory in the workspace. See `iterate.search`.

        Args:
            model: The model.
            work: The solver's workspace, or its handle.
            max_iterations: Largest number of steps.
            deadline: See `iterate.search`.
        """
        return int(search(model, work, self._held, max_iterations, deadline))


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
        """The nominal trajectory, to keep.

        Args:
            work: Workspace of the solver.
            cost: J of it.
        """
        return cls(
            cost, work.nominal.states.copy(), work.nominal.inputs.copy(), work.policy.gains.copy(),
            Multipliers(*(array.copy() for array in work.multipliers)),
        )  # fmt: skip

    def costs_as(self, other: Kept) -> bool:
        """Whether both are at the same minimum, judged by their costs.

        Args:
            other: The other one.
        """
        return abs(self.cost - other.cost) <= _SAME * (1.0 + abs(other.cost))

    def put_back(self, work: Workspace) -> None:
        """Make it the nominal trajectory again.

        Args:
            work: Workspace of the solver, changed.
        """
        np.copyto(work.nominal.states, self.states)
        np.copyto(work.nominal.inputs, self.inputs)
        np.copyto(work.policy.gains, self.gains)
        for source, target in zip(self.multipliers, work.multipliers, strict=True):
            np.copyto(target, source)
