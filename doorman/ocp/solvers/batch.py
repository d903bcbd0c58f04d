"""Many solves of one problem side by side, each thread with a solver of its own; kernels run without the interpreter's lock."""

from __future__ import annotations

import copy
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from queue import SimpleQueue
from typing import Any, Protocol, TypeVar

from doorman.checks import whole

Result = TypeVar("Result")


class Forgetful(Protocol):
    """A solver whose next solve does not depend on those before."""

    def forget(self) -> None:
        """Forget what earlier solves have left."""

    def stop(self) -> None:
        """End the solve that runs, from another thread."""


Worker = TypeVar("Worker", bound=Forgetful)


def solve_all(
    solver: Worker, starts: Sequence[Any], solve: Callable[[Worker, Any], Result], threads: int | None
) -> list[Result | Exception]:
    """Solve from many starts."""
    count = min(whole(threads or os.cpu_count() or 1, "threads", 1), max(len(starts), 1))
    free: SimpleQueue[Worker] = SimpleQueue()
    workers = [copy.deepcopy(solver) for _ in range(count)]
    for each in workers:
        free.put(each)

    def one(start: Any) -> Result | Exception:
        worker = free.get()
        try:
            worker.forget()
            return solve(worker, start)
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
