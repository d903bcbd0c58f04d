"""Order in which a solver's kernels are compiled: two processes that begin at different ends share the work by the cache."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_LAST_FIRST = ContextVar("_LAST_FIRST", default=False)


@contextmanager
def last_first() -> Iterator[None]:
    """Solvers that are made meanwhile begin with the kernels that they otherwise compile last."""
    token = _LAST_FIRST.set(True)
    try:
        yield
    finally:
        _LAST_FIRST.reset(token)


def is_last_first() -> bool:
    """Whether a solver that is made now begins with the last kernels."""
    return _LAST_FIRST.get()
