"""CasADi's solvers of nonlinear programs, called without copies."""

from __future__ import annotations

from typing import Any, Protocol

import casadi as ca
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class ShootingProgram(Protocol):
    """A program by multiple shooting."""

    program: dict[str, Any]
    lower_rows: Array
    upper_rows: Array
    lower: Array
    upper: Array

    def unpack(self, variables: Array) -> tuple[Array, Array]:
        """States and inputs from variables."""


class BufferedProgram:
    """An `nlpsol` solver of a shooting program, called through CasADi's function buffer.

    Args:
        shooting: The program.
        plugin: Name of CasADi's plugin.
        options: Options of `nlpsol`.
    """

    def __init__(self, shooting: ShootingProgram, plugin: str, options: dict[str, Any]) -> None:
        self._program = shooting
        solver = ca.nlpsol("solver", plugin, shooting.program, {"print_time": False, **options})
        self._buffer: Any
        self._buffer, self._evaluate = solver.buffer()
        self._in = {name: np.zeros(solver.size_in(name)[0]) for name in solver.name_in()}
        self._out = {name: np.zeros(solver.size_out(name)[0]) for name in solver.name_out()}
        for arrays, connect in ((self._in, self._buffer.set_arg), (self._out, self._buffer.set_res)):
            for i, array in enumerate(arrays.values()):
                if array.size:
                    connect(i, array.data)
        self._in["lbg"][:], self._in["ubg"][:] = shooting.lower_rows, shooting.upper_rows
        self._in["lbx"][:], self._in["ubx"][:] = shooting.lower, shooting.upper

    def run(self) -> None:
        """Solve: the part that is timed."""
        self._evaluate()

    @property
    def stats(self) -> dict[str, Any]:
        """CasADi's statistics of the last run."""
        stats: dict[str, Any] = self._buffer.stats()
        return stats

    def trajectory(self) -> tuple[Array, Array]:
        """States and inputs of the last run."""
        return self._program.unpack(self._out["x"])
