"""A problem of a printed module: numbers for what is in its text."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np

from doorman.arrays import Array
from doorman.compilation import cache_directory
from doorman.compilation.cache_files import write_atomically
from doorman.ocp.kernels.printed.loading import load
from doorman.ocp.problem.costs import QuadraticCost
from doorman.ocp.problem.problem import Bounds, Problem

_SOLVER = Path(__file__).parents[2]
_OWN = ("problem", "kernels")
"""Folders of the solver that make texts."""


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


def kept_text(key: str, make: Callable[[], str], packages: Sequence[ModuleType] = ()) -> str:
    """Text that is made once and kept on disk until code of the solver or of these packages changes: no warm start derives."""
    try:
        path = cache_directory() / "problems" / f"{_digest(key + _code(*packages))[:16]}.txt"
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
def _code(*packages: ModuleType) -> str:
    """Digest of the code that texts are made by."""
    digest = hashlib.sha256()
    folders = [*(Path(package.__path__[0]) for package in packages), *(_SOLVER / folder for folder in _OWN)]
    for folder in folders:
        for source in sorted(folder.rglob("*.py")):
            digest.update(source.read_bytes())
    return digest.hexdigest()


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
