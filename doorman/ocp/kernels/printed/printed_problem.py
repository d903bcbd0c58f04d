"""A problem of a printed module: numbers for what is in its text."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import cache_directory
from doorman.compilation.cache_files import write_atomically
from doorman.ocp.kernels.printed.loading import load
from doorman.ocp.problem.costs import QuadraticCost
from doorman.ocp.problem.problem import Bounds, Problem

Array = NDArray[np.float64]

_PACKAGE = Path(__file__).parents[3]
_FOLDERS = ("kinematics", "dynamics", "collision", "planning", "ocp/problem", "ocp/kernels")


def printed_problem(
    text: str, horizon: int, time_step: float, cost: QuadraticCost, bounds: Bounds | None, parameters: Array,
    node_parameters: Array | None = None,
) -> Problem:  # fmt: skip
    """Problem of a module's text; its kernels are compiled by the first solver of it, and kept on disk."""
    module = load(text)
    at_nodes = np.zeros((horizon + 1, module.NODE_PARAMETERS)) if node_parameters is None else node_parameters
    rows, input_rows, end_rows = module.ROWS
    return Problem(
        module.Model.of(time_step, np.array(parameters, dtype=np.float64), at_nodes),
        horizon=horizon, time_step=time_step, cost=cost, bounds=bounds or Bounds(),
        n_constraints=rows, n_input_constraints=input_rows, n_end_constraints=end_rows,
        integrators=module.INTEGRATORS, constraint_names=module.NAMES, equalities=module.EQUALITIES,
    )  # fmt: skip


def kept_text(key: str, make: Callable[[], str]) -> str:
    """Text that is made once and kept on disk: a warm start needs neither CasADi nor the time to derive."""
    try:
        path = cache_directory() / "problems" / f"{_digest(key + _code())[:16]}.txt"
    except OSError:
        return make()  # and again next time
    try:
        first, _, text = path.read_text(encoding="utf-8").partition("\n")
        if first == _digest(text):
            return text
    except OSError:
        pass
    text = make()
    try:
        write_atomically(path, f"{_digest(text)}\n{text}".encode())
    except OSError:
        pass  # made again next time
    return text


@cache
def _code() -> str:
    """Digest of the package's code that texts are made by."""
    digest = hashlib.sha256()
    for folder in _FOLDERS:
        for source in sorted((_PACKAGE / folder).rglob("*.py")):
            digest.update(source.read_bytes())
    return digest.hexdigest()


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
