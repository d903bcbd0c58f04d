"""Many solves of one problem side by side, each thread with a solver of its own; kernels run without the interpreter's lock."""

from __future__ import annotations

import copy
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from queue import SimpleQueue
from typing import Any

from doorman.checks import whole


def solve_all(
    solver: Any, starts: Sequence[tuple[Any, ...]], solve: Callable[..., Any], threads: int | None
) -> list[Any]:  # fmt: skip
    """Call `solve(copy, *start)` for many starts, of copies that forget what was before; an exception is a result, too."""
    count = min(whole(threads or os.cpu_count() or 1, "threads", 1), max(len(starts), 1))
    free: SimpleQueue[Any] = SimpleQueue()
    workers = [copy.deepcopy(solver) for _ in range(count)]
    for each in workers:
        free.put(each)

    def one(start: tuple[Any, ...]) -> Any:
        worker = free.get()
        try:
            worker.forget()
            return solve(worker, *start)
        except Exception as error:
            return error
        finally:
            free.put(worker)

    with ThreadPoolExecutor(count) as pool:
        try:
            return list(pool.map(one, starts))
        except BaseException:  # an interrupt: the pool waits for what runs
            for each in workers:
                each.stop()
            raise
