"""A line on stderr while a solver's kernels are compiled, so that the wait does not look like a hang."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import event

from doorman.ocp.problem.problem import Problem


class _Once(event.Listener):
    """Prints words when the first kernel is compiled."""

    def __init__(self, words: str) -> None:
        self._words = words

    def on_start(self, event: Any) -> None:
        if self._words:
            print(self._words, file=sys.stderr, flush=True)
            self._words = ""

    def on_end(self, event: Any) -> None:
        pass


@contextmanager
def compilation_told(problem: Problem) -> Iterator[None]:
    """Say what is compiled meanwhile, if anything is; kernels that come from the cache are not worth a word."""
    if type(problem.model).__module__.partition(".")[0] == "doorman":
        yield
        return
    rows = problem.n_constraints + problem.n_input_constraints + problem.n_end_constraints
    counts = [
        _counted(problem.nx, "state"),
        _counted(problem.nu, "input"),
        *([_counted(rows, "constraint")] if rows else []),
    ]
    with event.install_listener("numba:compile", _Once(f"doorman: compiling {', '.join(counts)} …")):
        yield


def _counted(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"
