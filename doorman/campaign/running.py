"""Running a campaign on Dask: every flight in a process of its own, every result durable at once, what is done is not redone."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from distributed import Client, Future

from doorman.campaign.flights.cluster import answer_of, close_processes, connected, first_done, fly, threads_of
from doorman.campaign.flights.flight_process import ATTEMPTS, failed
from doorman.campaign.flights.orders import order_of, packed
from doorman.campaign.folder import RESULTS, claimed, write_not_flown
from doorman.campaign.results import Row, read_parts, row_of, write_part, write_table
from doorman.campaign.specification import Campaign, Flight
from doorman.cores import usable_cores
from doorman.exceptions import DoormanError
from doorman.flown import carried_files

OnRow = Callable[[Row, int, int], None]
"""Called with a new row, the number of rows known, and the number of runs."""

_HOPELESS = 20
"""So many such failures in a row, and no flight between them, end a campaign."""
_AHEAD = 4
"""Flights that are ordered ahead, for each thread of the cluster."""


def run_campaign(
    campaign: Campaign,
    out: Path,
    runs: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    on_row: OnRow | None = None,
) -> list[Row]:
    """Fly what is not yet flown of a campaign."""
    # Every run is flown in a process of its own: one that hangs costs its row and nothing else. What machine or
    # software does to a flight is no result: the run is tried again, and if nothing comes of that, it has no row, and
    # `not_flown.json` says why. Results are written by this process alone, one file a run, as they come in.
    flights = campaign.flights(runs)
    with claimed(out, campaign) as parts:
        known = {run for run in read_parts(parts, removes_damaged=True) if run < len(flights)}
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
        ordered = [rows[run] for run in sorted(known & rows.keys())]
        write_table(ordered, out / RESULTS)
    return ordered


def durable_rows(out: Path) -> list[Row]:
    """Rows that a campaign has written so far, in the order of their runs."""
    rows = read_parts(out / "runs")
    return [rows[run] for run in sorted(rows)]


def _flown(client: Client, campaign: Campaign, runs: Iterator[int]) -> Iterator[tuple[Flight, dict[str, Any]]]:
    """Flights and answers in the order in which they come in; what was lost comes when it was tried often enough."""
    orders = _Orders(client, campaign)
    losses = 0
    try:
        waiting = True
        while waiting or orders.futures:
            while waiting and len(orders.futures) < _AHEAD * max(threads_of(client), 1):
                run = next(runs, None)
                if run is None:
                    waiting = False
                    break
                problem = orders.submit(run)
                if problem is not None:
                    yield problem
            for future in first_done(client, list(orders.futures)) if orders.futures else []:
                flight, tried = orders.futures.pop(future)
                answer = answer_of(future)
                future.release()  # type: ignore[no-untyped-call]
                losses = losses + 1 if answer.get("lost") else 0
                if losses >= _HOPELESS:
                    raise DoormanError(f"{losses} flights in a row did not start; the last error: {answer['error']}")
                if answer.get("lost") and tried < ATTEMPTS:
                    orders.send(flight, tried + 1)
                else:
                    yield flight, answer
    finally:
        orders.close()


class _Orders:
    """What a client has ordered of a cluster, and the files that go with it."""

    def __init__(self, client: Client, campaign: Campaign) -> None:
        self.futures: dict[Future[Any], tuple[Flight, int]] = {}  # flights that are ordered, and how often each was
        self._client, self._campaign = client, campaign
        self._name = uuid.uuid4().hex
        self._files: dict[tuple[Path, Path], tuple[dict[str, bytes], Future[Any]]] = {}

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
        contents, sent = self._carried(flight)
        key = f"flight-{flight.draw.run}-{tried}-{self._name}"
        future = self._client.submit(
            fly, order_of(flight, contents), sent, flight.time_out, self._name, sent.key, key=key, pure=False, retries=0
        )
        self.futures[future] = flight, tried

    def close(self) -> None:
        """Take back what is ordered, and let the flight processes go."""
        self._client.cancel(list(self.futures))  # type: ignore[no-untyped-call]
        with suppress(Exception):  # a cluster that is gone has closed them
            self._client.run(close_processes, self._name)

    def _carried(self, flight: Flight) -> tuple[dict[str, bytes], Future[Any]]:
        """URDFs and meshes, read once; on the cluster, where they are the lease by which workers see that this client lives."""
        paths = flight.scenario.vehicle_urdf, flight.scenario.door_urdf
        if paths not in self._files:
            contents, key = carried_files(flight.scenario), f"files-{len(self._files)}-{self._name}"
            self._files[paths] = contents, self._client.submit(dict, packed(contents), key=key, pure=False)
        return self._files[paths]
