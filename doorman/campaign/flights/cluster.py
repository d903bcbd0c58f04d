"""The Dask cluster of a campaign: one at an address, or one made here, and what its flights answer."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from typing import Any

import dask
from distributed import Client, Future, LocalCluster, wait

from doorman.campaign.flights.flight_process import lost
from doorman.exceptions import DoormanError

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
