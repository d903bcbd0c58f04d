"""Leases: how a worker of a cluster notices that a campaign's client is gone, and lets its flight processes go.

The client holds a small result on the cluster. When the client dies, the scheduler forgets the result; workers ask for it.
"""

from __future__ import annotations

import threading
from collections.abc import Callable

from distributed import Worker
from distributed.utils import sync

INTERVAL = 2.0
"""How often a worker asks [s]."""
_PATIENCE = 3
"""Answers that may fail to come, as from a busy scheduler."""


class Lease:
    """Watches one campaign on one worker."""

    def __init__(self, worker: Worker, key: str, over: Callable[[], None]) -> None:
        self._worker, self._key, self._over = worker, key, over
        self._ended = threading.Event()
        threading.Thread(target=self._watch, name="campaign lease", daemon=True).start()

    def end(self) -> None:
        """Stop watching."""
        self._ended.set()

    def _watch(self) -> None:
        failures = 0
        while not self._ended.wait(INTERVAL):
            held = self._is_held()
            failures = failures + 1 if held is None else 0
            if held is False or failures >= _PATIENCE:
                self._over()
                return

    def _is_held(self) -> bool | None:
        """Whether the scheduler knows of it; None if it does not answer."""
        try:
            found = sync(self._worker.loop, self._worker.scheduler.who_has, keys=[self._key], callback_timeout=INTERVAL)
        except Exception:  # closed connections, time-outs, a loop that has ended
            return None
        return bool(found.get(self._key))
