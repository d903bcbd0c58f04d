"""What a worker of the cluster does: each of its threads flies in a flight process of its own, until the lease ends.

The client holds a small result on the cluster, the lease. When the client dies, the scheduler forgets it; workers ask for it.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from distributed import Worker, get_worker
from distributed.utils import sync

from doorman.campaign.flights.flight_process import FlightProcesses

INTERVAL = 2.0
"""How often a worker asks [s]."""
_PATIENCE = 3
"""Answers that may fail to come, as from a busy scheduler."""

_processes: dict[str, FlightProcesses] = {}
"""Flight processes of this process, by campaign."""
_leases: dict[str, Lease] = {}
"""Leases of this process, by campaign."""
_lock = threading.Lock()


def fly(order: dict[str, Any], files: dict[str, str], time_out: float, campaign: str, lease: str) -> dict[str, Any]:
    """Fly one run in the process that belongs to this thread of a worker."""
    with _lock:
        processes = _processes.setdefault(campaign, FlightProcesses())
        if campaign not in _leases:
            _leases[campaign] = Lease(get_worker(), lease, lambda: close_processes(campaign))
    return processes.mine().fly(order, files, time_out)


def close_processes(campaign: str) -> None:
    """Let the flight processes of a campaign go, on this worker."""
    with _lock:
        processes, watched = _processes.pop(campaign, None), _leases.pop(campaign, None)
    if watched is not None:
        watched.end()
    if processes is not None:
        processes.close()


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
