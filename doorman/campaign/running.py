"""Running a campaign on Dask: every flight in a process of its own, every result durable at once, what is done is not redone."""

from __future__ import annotations

import logging
import os
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import dask
from distributed import Client, Future, LocalCluster, wait

from doorman.campaign.cockpit import Cockpit, failed
from doorman.campaign.folder import RESULTS, claimed
from doorman.campaign.results import Row, read_parts, row_of, write_part, write_table
from doorman.campaign.specification import Campaign, Flight
from doorman.exceptions import DoormanError

OnRow = Callable[[Row, int, int], None]
"""Called with a new row, the number of rows known, and the number of runs."""

_CONNECTION_TIME = 10.0
"""Longest time to find a cluster [s]."""
_LOOK = 5.0
"""How often it is looked whether the cluster has workers [s]."""
_WORKERLESS = 300.0
"""A cluster without a worker for so long flies nothing any more [s]."""
_NEVER_LOST = {"distributed.scheduler.worker-ttl": None}
"""Workers in this process are not given up for silence: after a suspended night nobody would start others."""
_STATUS_PAGE = "127.0.0.1:0"
"""Of a local cluster and its workers: without an address Dask listens on port 8787 of every interface, or on another one."""

_cockpits: dict[tuple[str, int], Cockpit] = {}
"""Of this process, by campaign and thread."""


def run_campaign(
    campaign: Campaign,
    out: Path,
    runs: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    on_row: OnRow | None = None,
) -> list[Row]:
    """Fly what is not yet flown of a campaign.

    Every run is flown in a process of its own: one that hangs or dies costs its row and nothing else. Results are written by
    this process alone, one file a run, as they come in.

    Args:
        campaign: The campaign.
        out: Its folder.
        runs: Number of runs; by default the scenario's. More runs than before continue a finished campaign.
        workers: Flights at a time, on this machine; by default one for every core.
        scheduler: Address of an existing Dask cluster, whose workers have the same doorman installed.
        on_row: Called after every run.

    Returns:
        One row for every run, in their order; the same are in `results.parquet`.

    Raises:
        DoormanError: if the scenario cannot be used, the folder holds another campaign, or the cluster is not found.
    """
    flights = {flight.draw.run: flight for flight in campaign.flights(runs)}
    with claimed(out, campaign) as parts:
        rows = {run: row for run, row in read_parts(parts).items() if run in flights}
        missing = [flight for run, flight in flights.items() if run not in rows]
        if missing:
            with connected(min(workers or _cores(), len(missing)), scheduler) as client:
                for row in _flown(client, missing):
                    write_part(row, parts)
                    rows[row["run"]] = row
                    if on_row is not None:
                        on_row(row, len(rows), len(flights))
        ordered = [rows[run] for run in sorted(rows)]
        write_table(ordered, out / RESULTS)
    return ordered


def durable_rows(out: Path) -> list[Row]:
    """Rows that a campaign has written so far, in the order of their runs."""
    rows = read_parts(out / "runs")
    return [rows[run] for run in sorted(rows)]


def _flown(client: Client, flights: list[Flight]) -> Iterator[Row]:
    """Rows in the order in which they come in."""
    campaign = uuid.uuid4().hex
    futures: dict[Future[Any], Flight] = {}
    for flight in flights:
        key = f"flight-{flight.draw.run}-{campaign}"
        futures[client.submit(fly, flight.order(), flight.time_out, campaign, key=key, pure=False)] = flight
    try:
        while futures:
            for future in _done(client, list(futures)):
                yield row_of(futures.pop(future), _answer(future))
                future.release()  # type: ignore[no-untyped-call]
    finally:
        client.cancel(list(futures))  # type: ignore[no-untyped-call]
        with suppress(Exception):  # a cluster that is gone has closed them
            client.run(close_cockpits, campaign)


def _done(client: Client, futures: list[Future[Any]]) -> list[Future[Any]]:
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
                    allowed="a cluster with workers; the same command goes on where this one ended",
                ) from None  # fmt: skip


def _answer(future: Future[Any]) -> dict[str, Any]:
    """The pilot's answer, or that its worker was lost."""
    if future.status == "finished":
        answer: dict[str, Any] = future.result()
        return answer
    return failed(f"the worker was lost: {future.exception()!r}")  # type: ignore[no-untyped-call]


def fly(order: dict[str, Any], time_out: float, campaign: str) -> dict[str, Any]:
    """Fly one run in the process that belongs to this thread of a worker.

    Args:
        order: As `Flight.order` makes it.
        time_out: Wall-clock time [s].
        campaign: Whose process it is.

    Returns:
        The pilot's answer.
    """
    cockpit = _cockpits.setdefault((campaign, threading.get_ident()), Cockpit())
    return cockpit.fly(order, time_out)


def close_cockpits(campaign: str) -> None:
    """Let the pilots of a campaign go, on this worker.

    Args:
        campaign: The campaign.
    """
    for key in [key for key in _cockpits if key[0] == campaign]:
        _cockpits.pop(key).close()


@contextmanager
def connected(workers: int, scheduler: str | None) -> Iterator[Client]:
    """A client of the cluster at an address, or of one made here, whose workers are threads that wait for their pilots."""
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


def _cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
