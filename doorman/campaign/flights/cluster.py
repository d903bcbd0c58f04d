"""The Dask cluster of a campaign: one at an address, or one made here; what its workers do, and what its flights answer."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from typing import Any

import dask
from distributed import Client, Future, LocalCluster, Worker, get_worker, wait
from distributed.utils import sync

from doorman.campaign.flights.flight_process import FlightProcesses, lost
from doorman.exceptions import DoormanError

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
    """Watches one campaign on one worker: its client holds a small result, which the scheduler forgets when the client dies."""

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


_CONNECTION_TIME = 10.0
"""Longest time to find a cluster [s]."""
_LOOK = 5.0
"""How often it is looked whether the cluster has workers [s]."""
_WORKERLESS = 300.0
"""A cluster without a worker for so long flies nothing any more [s]."""
_NEVER_LOST = {"distributed.scheduler.worker-ttl": None}
"""Workers in this process are not given up for silence: after a suspended night none would be started."""
_STATUS_PAGE = "127.0.0.1:0"
"""Address of the status page: without one, Dask listens on a port of every interface."""


def threads_of(client: Client) -> int:
    """Threads of the cluster."""
    return sum(int(worker.get("nthreads", 1)) for worker in client.scheduler_info()["workers"].values())


def first_done(client: Client, futures: list[Future[Any]]) -> list[Future[Any]]:
    """Wait for one of the flights at least, as long as the cluster has workers."""
    workers_seen = time.monotonic()
    while True:
        try:
            return list(wait(futures, timeout=_LOOK, return_when="FIRST_COMPLETED").done)  # type: ignore[no-untyped-call]
        except CancelledError as error:
            raise DoormanError(f"the cluster has dropped a flight: {error}", field="--scheduler") from error
        except TimeoutError:
            now = time.monotonic()
            if client.scheduler_info()["workers"]:
                workers_seen = now
            elif now - workers_seen > _WORKERLESS:
                raise DoormanError(
                    f"the cluster has had no worker for {now - workers_seen:.0f} s", field="--scheduler",
                    allowed="a cluster with workers; the same command continues this campaign",
                ) from None  # fmt: skip


def answer_of(future: Future[Any]) -> dict[str, Any]:
    """The flight process's answer, or that its worker was lost."""
    if future.status == "finished":
        answer: dict[str, Any] = future.result()
        return answer
    return lost(f"the worker was lost: {future.exception()!r}")  # type: ignore[no-untyped-call]


@contextmanager
def connected(workers: int, scheduler: str | None) -> Iterator[Client]:
    """A client of the cluster at an address, or of one made here, whose workers are threads that wait for flight processes."""
    logging.getLogger("distributed").setLevel(logging.ERROR)
    if scheduler is None:
        with (
            dask.config.set(_NEVER_LOST),
            LocalCluster(  # type: ignore[no-untyped-call]
                n_workers=workers,
                threads_per_worker=1,
                processes=False,
                dashboard_address=_STATUS_PAGE,
                worker_dashboard_address=_STATUS_PAGE,
                memory_limit=None,
            ) as cluster,
            Client(cluster) as client,  # type: ignore[no-untyped-call]
        ):
            yield client
        return
    try:
        client = Client(scheduler, timeout=_CONNECTION_TIME)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        raise DoormanError(
            f"no Dask scheduler answers: {error}", field="--scheduler", given=scheduler, allowed="tcp://host:port"
        ) from error
    with client:
        yield client
