"""Batch: one scenario flown with many seeds, on all cores of this machine."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from doorman.campaign.flights.flight_process import ATTEMPTS, FlightProcesses, lost
from doorman.campaign.flights.orders import order_of, packed
from doorman.campaign.specification import Draw, Flight
from doorman.checks import positive, whole
from doorman.cores import usable_cores
from doorman.exceptions import DoormanError
from doorman.feasibility import Report
from doorman.flown import carried_files
from doorman.mission.simulate import checked
from doorman.model import Model
from doorman.one_line import OneLine
from doorman.scenario import Scenario


@dataclass(frozen=True, eq=False, repr=False)
class BatchFlight(OneLine):
    """One flight of a batch."""

    seed: int
    """Seed of its noise and gusts."""
    summary: dict[str, Any] | None
    """The keys of `summary.json`, as `Recording.summary` has them; None where there is an error."""
    error: str
    """What kept the flight from coming to an end; empty where nothing did."""
    recording: Path | None
    """Its file, where a folder was given."""
    wall_time: float
    """Duration on the wall clock, with the construction of its model [s]; NaN if its process died."""


OnFlight = Callable[[BatchFlight], None]
"""Called with every flight as it comes in, in the thread of the caller."""


def simulate_batch(
    scenario: Scenario | Model | str | os.PathLike[str],
    seeds: Iterable[int],
    duration: float | None = None,
    *,
    workers: int | None = None,
    folder: str | os.PathLike[str] | None = None,
    on_flight: OnFlight | None = None,
    force: bool = False,
    report: Report | None = None,
) -> list[BatchFlight]:
    """Fly a scenario in simulation with every one of some seeds, each flight as `doorman.simulate` flies it.

    Flights are flown in processes of their own, one for every core, each with one thread. One that dies or hangs costs its own
    flight. Only summaries come back; recordings go to a folder.

    Args:
        scenario: The scenario, its name or path, or a model of it.
        seeds: Of the sensors' noise and the gusts, integers >= 0; none twice.
        duration: Simulated time of each at most, > 0 [s]; to the mission's end if not given.
        workers: Flights at a time, >= 1; by default one for every core that this process may use.
        folder: Where every flight is recorded, as `seed-3.mcap`; made if it does not exist. Not recorded if not given.
        on_flight: Called with every flight as it comes in.
        force: Fly even what the check refuses; without a report, nothing is checked.
        report: Of the check, where it was made before; else it is made here, once.

    Returns:
        The flights, in the order of the seeds.

    Raises:
        InfeasibleError: if the check refuses the scenario; nothing is flown.
        DoormanError: if the scenario, a seed or another argument cannot be used.
        OSError: if the folder cannot be made.
    """
    numbers = _checked_seeds(seeds)
    longest = None if duration is None else positive(duration, "duration")
    count = min(usable_cores() if workers is None else whole(workers, "workers", 1), max(len(numbers), 1))
    model = scenario if isinstance(scenario, Model) else Model(scenario)
    checked(model, force, report)
    files = carried_files(model.scenario)
    contents = packed(files)
    place = None if folder is None else Path(folder).absolute()
    if place is not None:
        place.mkdir(parents=True, exist_ok=True)
    time_out = model.scenario.campaign.time_out

    def fly(processes: FlightProcesses, index: int) -> BatchFlight:
        seed = numbers[index]
        path = None if place is None else place / f"seed-{seed}.mcap"
        flight = Flight(Draw(index, seed, {}), model.scenario, longest, time_out, "")
        order = {**order_of(flight, files), "path": None if path is None else str(path)}
        answer = lost("the batch was ended")
        for _ in range(ATTEMPTS):
            if answer.get("lost") and not processes.over:
                answer = processes.mine().fly(order, contents, time_out)
        seconds = answer["wall_time_s"]
        return BatchFlight(
            seed, answer["summary"], answer["error"] or "", path if answer["summary"] is not None else None,
            float("nan") if seconds is None else seconds,
        )  # fmt: skip

    flown: dict[int, BatchFlight] = {}
    with closing(FlightProcesses()) as processes, ThreadPoolExecutor(count) as pool:
        futures = {pool.submit(fly, processes, index): index for index in range(len(numbers))}
        try:
            for future in as_completed(futures):
                flown[futures[future]] = flight = future.result()
                if on_flight is not None:
                    on_flight(flight)
        except BaseException:  # Ctrl-C too, or the caller's function: nothing more is begun, and what flies is ended
            pool.shutdown(wait=False, cancel_futures=True)
            processes.close()
            raise
    return [flown[index] for index in range(len(numbers))]


def _checked_seeds(seeds: Iterable[int]) -> list[int]:
    numbers = [whole(seed, f"seeds[{index}]", 0) for index, seed in enumerate(seeds)]
    if len(set(numbers)) < len(numbers):
        twice = next(seed for seed in numbers if numbers.count(seed) > 1)
        raise DoormanError("a seed is given twice", field="seeds", given=twice, allowed="seeds that differ")
    return numbers
