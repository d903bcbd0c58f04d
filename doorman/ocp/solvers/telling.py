"""Kernels that come back between iterations: to tell the caller of each one, to let signals through, to end a solve early."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from doorman.ocp.solvers.memory.result import Result

Phase = Literal["fast", "interior", "careful", "descent"]

_SLICE = 0.02
"""Kernels come back after so long: Python sees no signal, such as Ctrl-C, while one runs [s]."""


@dataclass(frozen=True)
class Iterate:
    """One iteration of a solve."""

    phase: Phase
    """Fast augmented Lagrangian iterations, the interior-point search, careful iterations, or descent of CDDP."""
    iteration: int
    """Within the phase, from 1."""
    cost: float
    """J; with defects it may lie below what the solve ends with."""
    violation: float
    """Largest violated row or bound [the row's unit]."""
    defect: float
    """Largest |f(x_k, u_k) − x_{k+1}|."""
    step: float
    """Largest change of an input by the iteration's full step, times its weight."""


Callback = Callable[[Iterate], object]
"""Gets every iteration; where it returns something true, the solve ends."""


class Stopped(Exception):
    """The callback, or `Teller.stop`, has ended the solve."""


class Teller:
    """Runs kernels, and tells a callback of their iterations if there is one.

    Args:
        result: That of the workspace.
    """

    def __init__(self, result: Result) -> None:
        self._result = result
        self.callback: Callback | None = None
        self._stopping = False

    def stop(self) -> None:
        """End the solve that runs in another thread, and all later ones."""
        self._stopping = True

    def run(
        self, phase: Phase, kernel: Callable[[], int], paused: int, goes_on: Callable[[], bool] | None = None
    ) -> int:
        """Call a kernel until it has come to its end."""
        result, each = self._result, self.callback is not None or goes_on is not None
        try:
            result.pause = 0.0 if each else time.monotonic() + _SLICE
            code = kernel()
            while code == paused and (goes_on is None or goes_on()):
                self.tell(phase)
                result.resumes = True
                result.pause = 0.0 if each else time.monotonic() + _SLICE
                code = kernel()
        finally:
            result.pause, result.resumes = math.inf, False
        self.tell(phase)
        return code

    def tell(self, phase: Phase, iteration: int | None = None) -> None:
        """Tell the callback of the iteration that has just ended."""
        result = self._result
        if self._stopping:
            raise Stopped
        if self.callback is None:
            return
        count = result.iterations if iteration is None else iteration
        iterate = Iterate(phase, count, result.cost, result.violation, result.defect, result.change)
        if self.callback(iterate):
            raise Stopped
