"""Running a campaign on Dask: every flight in a process of its own, every result durable at once, what is done is not redone."""

from __future__ import annotations

import logging
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import dask
from distributed import Client, Future, LocalCluster, get_worker, wait

from doorman.campaign.batch import usable_cores
from doorman.campaign.flights.flight_process import FlightProcess, failed, lost
from doorman.campaign.flights.lease import Lease
from doorman.campaign.flights.orders import order_of, packed
from doorman.campaign.folder import RESULTS, claimed, write_not_flown
from doorman.campaign.results import Row, known_runs, read_parts, row_of, write_part, write_table
from doorman.campaign.specification import Campaign, Flight
from doorman.exceptions import DoormanError
from doorman.flown import carried_files
from doorman.scenario import Scenario

OnRow = Callable[[Row, int, int], None]
"""Called with a new row, the number of rows known, and the number of runs."""

_ATTEMPTS = 3
"""How often a run is tried whose worker, process or disk fails: that says nothing about the flight."""
_HOPELESS = 20
"""So many such failures in a row, and no flight between them, end a campaign."""
_AHEAD = 4
"""Flights that are ordered ahead, for each thread of the cluster."""
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

_processes: dict[tuple[str, int], FlightProcess] = {}
"""Of this process, by campaign and thread."""
_leases: dict[str, Lease] = {}
"""Of this process, by campaign."""
_processes_lock = threading.Lock()


def run_campaign(
    campaign: Campaign,
    out: Path,
    runs: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    on_row: OnRow | None = None,
) -> list[Row]:
    """Fly what is not yet flown of a campaign.

    Every run is flown in a process of its own: one that hangs costs its row and nothing else. What machine or software does to a
    flight is no result: the run is tried again, and if nothing comes of that, it has no row, and `not_flown.json` says why.
    Results are written by this process alone, one file a run, as they come in.

    Args:
        campaign: The campaign.
        out: Its folder.
        runs: Number of runs; by default the scenario's. More runs than before continue a finished campaign.
        workers: Flights at a time, on this machine; by default one for every core.
        scheduler: Address of an existing Dask cluster, whose workers have the same doorman installed.
        on_row: Called after every run.

    Returns:
        One row for every run that was flown, in their order; the same are in `results.parquet`.

    Raises:
        DoormanError: if the scenario cannot be used, the folder holds another campaign, the cluster is not found, or flies
            nothing.
    """
    flights = campaign.flights(runs)
    with claimed(out, campaign) as parts:
        known = {run for run in known_runs(parts) if run < len(flights)}
        missing = (run for run in range(len(flights)) if run not in known)
        not_flown: dict[int, str] = {}
        count = len(flights) - len(known)
        try:
            if count:
                with connected(min(workers or usable_cores(), count), scheduler) as client:
                    for flight, answer in _flown(client, campaign, missing):
                        if answer.get("lost"):
                            not_flown[flight.draw.run] = str(answer["error"])
                            continue
                        row = row_of(flight, answer)
                        write_part(row, parts)
                        known.add(row["run"])
                        if on_row is not None:
                            on_row(row, len(known), len(flights))
        finally:
            write_not_flown(not_flown, out)
        rows = read_parts(parts)
        ordered = [rows[run] for run in sorted(known)]
        write_table(ordered, out / RESULTS)
    return ordered


def durable_rows(out: Path) -> list[Row]:
    """Rows that a campaign has written so far, in the order of their runs.

    Args:
        out: Folder of the campaign.
    """
    rows = read_parts(out / "runs")
    return [rows[run] for run in sorted(rows)]


def _flown(client: Client, campaign: Campaign, runs: Iterator[int]) -> Iterator[tuple[Flight, dict[str, Any]]]:
    """Flights and answers in the order in which they come in; what was lost comes when it was tried often enough."""
    orders = _Orders(client, campaign)
    losses = 0
    try:
        waiting = True
        while waiting or orders.futures:
            while waiting and len(orders.futures) < _AHEAD * max(_threads(client), 1):
                run = next(runs, None)
                if run is None:
                    waiting = False
                    break
                problem = orders.submit(run)
                if problem is not None:
                    yield problem
            for future in _done(client, list(orders.futures)) if orders.futures else []:
                flight, tried = orders.futures.pop(future)
                answer = _answer(future)
                future.release()  # type: ignore[no-untyped-call]
                losses = losses + 1 if answer.get("lost") else 0
                if losses >= _HOPELESS:
                    raise DoormanError(f"{losses} flights in a row did not come about; the last one: {answer['error']}")
                if answer.get("lost") and tried < _ATTEMPTS:
                    orders.send(flight, tried + 1)
                else:
                    yield flight, answer
    finally:
        orders.close()


class _Orders:
    """What a client has ordered of a cluster, and the files that go with it.

    Args:
        client: Of the cluster.
        campaign: The campaign.
    """

    def __init__(self, client: Client, campaign: Campaign) -> None:
        self.futures: dict[Future[Any], tuple[Flight, int]] = {}
        """Flights that are ordered, and how often each was."""
        self._client, self._campaign = client, campaign
        self._name = uuid.uuid4().hex
        self._files: dict[str, Future[Any]] = {}
        self._contents: dict[tuple[Path, Path], dict[str, bytes]] = {}

    def submit(self, run: int) -> tuple[Flight, dict[str, Any]] | None:
        """Order a run; one that cannot be drawn is a flight with its error at once."""
        try:
            flight = self._campaign.flight(run)
        except DoormanError as error:
            return self._campaign.undrawn(run), failed(f"{type(error).__name__}: {error}")
        self.send(flight, 1)
        return None

    def send(self, flight: Flight, tried: int) -> None:
        """Order a flight, for the first time or again."""
        contents = self._read(flight.scenario)
        order = order_of(flight, contents)
        files = self._sent(order, contents)
        key = f"flight-{flight.draw.run}-{tried}-{self._name}"
        future = self._client.submit(
            fly, order, files, flight.time_out, self._name, files.key, key=key, pure=False, retries=0
        )
        self.futures[future] = flight, tried

    def close(self) -> None:
        """Take back what is ordered, and let the flight processes go."""
        self._client.cancel(list(self.futures))  # type: ignore[no-untyped-call]
        with suppress(Exception):  # a cluster that is gone has closed them
            self._client.run(close_processes, self._name)

    def _read(self, scenario: Scenario) -> dict[str, bytes]:
        """URDFs and meshes of a scenario, read once."""
        paths = scenario.vehicle_urdf, scenario.door_urdf
        if paths not in self._contents:
            self._contents[paths] = carried_files(scenario)
        return self._contents[paths]

    def _sent(self, order: dict[str, Any], contents: dict[str, bytes]) -> Future[Any]:
        """The files of an order on the cluster: sent once, and the lease by which workers see that this client lives."""
        name = "-".join(order["files"].values())
        if name not in self._files:
            key = f"files-{name}-{self._name}"
            self._files[name] = self._client.submit(dict, packed(contents), key=key, pure=False)
        return self._files[name]


def _threads(client: Client) -> int:
    """Threads of the cluster."""
    return sum(int(worker.get("nthreads", 1)) for worker in client.scheduler_info()["workers"].values())


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
    """The flight process's answer, or that its worker was lost."""
    if future.status == "finished":
        answer: dict[str, Any] = future.result()
        return answer
    return lost(f"the worker was lost: {future.exception()!r}")  # type: ignore[no-untyped-call]


def fly(order: dict[str, Any], files: dict[str, str], time_out: float, campaign: str, lease: str) -> dict[str, Any]:
    """Fly one run in the process that belongs to this thread of a worker.

    Args:
        order: As `order_of` makes it.
        files: As `packed` makes them.
        time_out: Wall-clock time [s].
        campaign: Whose process it is.
        lease: Key of a result that the campaign's client holds as long as it lives.

    Returns:
        The flight process's answer.
    """
    with _processes_lock:
        flight_process = _processes.setdefault((campaign, threading.get_ident()), FlightProcess())
        if campaign not in _leases:
            _leases[campaign] = Lease(get_worker(), lease, lambda: close_processes(campaign))
    return flight_process.fly(order, files, time_out)


def close_processes(campaign: str) -> None:
    """Let the flight processes of a campaign go, on this worker.

    Args:
        campaign: The campaign.
    """
    with _processes_lock:
        processes = [_processes.pop(key) for key in list(_processes) if key[0] == campaign]
        watched = _leases.pop(campaign, None)
    if watched is not None:
        watched.end()
    for flight_process in processes:
        flight_process.close()


@contextmanager
def connected(workers: int, scheduler: str | None) -> Iterator[Client]:
    """A client of the cluster at an address, or of one made here, whose workers are threads that wait for flight processes.

    Args:
        workers: Number of a cluster that is made here.
        scheduler: Address of a cluster; None makes one here.
    """
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
