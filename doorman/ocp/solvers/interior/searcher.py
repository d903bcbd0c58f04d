"""The interior-point search as solvers call it: with its memory."""

from __future__ import annotations

from typing import Any

from doorman.numba_types.handles import held
from doorman.ocp.solvers.interior.certificate import is_minimum
from doorman.ocp.solvers.interior.iterate import search
from doorman.ocp.solvers.interior.memory import Interior
from doorman.ocp.solvers.memory.workspace import Workspace


class Searcher:
    """Interior-point search in the memory of a solver.

    Args:
        work: The solver's workspace.
    """

    def __init__(self, work: Workspace) -> None:
        self.memory = Interior.of(work)
        self._held = held(self.memory)

    def search(self, model: Any, work: Any, max_iterations: int, deadline: float) -> int:
        """Search from the nominal trajectory in the workspace. See `iterate.search`."""
        return int(search(model, work, self._held, max_iterations, deadline))

    def is_minimum(self, model: Any, work: Any, scale: float) -> bool:
        """Whether the nominal trajectory, a solution, is a minimum. See `certificate.is_minimum`."""
        return bool(is_minimum(model, work, self._held, scale))
