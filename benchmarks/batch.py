"""Measure batches of flights: flights a core-hour, memory of a flight process, and how two workers scale.

Usage: python benchmarks/batch.py [--scenario push] [--flights 4] [--workers 1 2]

A batch of one flight is flown first. What it costs is subtracted from the larger batch: imports, loading of kernels and the
rehearsal are left out, as they are in a night's campaign. Processor time is that of the flight processes. It says what a quiet
core would fly in an hour, even if other programs share the machine; the wall time does not.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import resource
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import doorman
from doorman.cores import usable_cores

_MEGABYTE = 1e6
_RSS_UNIT = 1 if sys.platform == "darwin" else 1024
"""Of `ru_maxrss` [bytes]."""


@dataclass(frozen=True)
class Cost:
    """What a batch took."""

    wall: float
    """[s]."""
    processor: float
    """Of the flight processes, user and system [s]."""


@dataclass(frozen=True)
class Row:
    """One number of workers."""

    workers: int
    flights: int
    """Beyond the first one of every worker."""
    simulated: float
    """Mean length of a flight [s]."""
    processor: float
    """Of one more flight [s]."""
    wall: float
    """Of one more flight [s]."""
    flights_a_core_hour: float
    """By processor time."""
    flights_an_hour: float
    """By wall time, of all workers."""
    memory: float
    """Largest resident memory of a flight process so far [MB]."""


def main() -> None:
    """Measure, print a table, write `batch.json`."""
    arguments = parse()
    scenario = doorman.Scenario.load(arguments.scenario)
    rows = [measure(scenario, arguments.flights, workers) for workers in arguments.workers]
    print(table(rows))
    if arguments.out is not None:
        arguments.out.parent.mkdir(parents=True, exist_ok=True)
        arguments.out.write_text(json.dumps([asdict(row) for row in rows], indent=2) + "\n", encoding="utf-8")


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenario", default="push", help="name or path")
    parser.add_argument("--flights", type=positive, default=4, help="for each worker, beyond the first")
    parser.add_argument("--workers", type=positive, nargs="+", default=list(range(1, min(usable_cores(), 2) + 1)))
    parser.add_argument("--out", type=Path, help="JSON file to write")
    return parser.parse_args()


def positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{number} is not positive")
    return number


def measure(scenario: doorman.Scenario, flights: int, workers: int) -> Row:
    """Fly a batch of one flight for each worker, then a larger one.

    Args:
        scenario: The scenario.
        flights: For each worker, beyond the first.
        workers: Flights at a time.
    """
    first, _ = fly(scenario, range(workers), workers)
    count = flights * workers
    whole, lengths = fly(scenario, range(workers + count), workers)
    processor, wall = whole.processor - first.processor, whole.wall - first.wall
    return Row(
        workers=workers, flights=count, simulated=sum(lengths) / len(lengths), processor=processor / count,
        wall=wall / count, flights_a_core_hour=3600.0 * count / processor, flights_an_hour=3600.0 * count / wall,
        memory=resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * _RSS_UNIT / _MEGABYTE,
    )  # fmt: skip


def fly(scenario: doorman.Scenario, seeds: range, workers: int) -> tuple[Cost, list[float]]:
    """Cost of a batch, and the lengths of its flights [s]; whoever calls has no other child that ends meanwhile."""
    wall, processor = time.perf_counter(), children()
    found = doorman.simulate_batch(scenario, seeds, workers=workers, force=True)
    cost = Cost(time.perf_counter() - wall, children() - processor)
    for flight in found:
        if flight.summary is None:
            raise SystemExit(f"seed {flight.seed} was not flown: {flight.error}")
    return cost, [float(flight.summary["duration_s"]) for flight in found if flight.summary is not None]


def children() -> float:
    """Processor time of all children that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def table(rows: list[Row]) -> str:
    """Rows as a Markdown table, under the machine's load.

    Args:
        rows: To print.
    """
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else math.nan
    lines = [
        f"{usable_cores()} cores, load {load:.1f}",
        "| workers | flights | simulated, s | processor, s a flight | flights a core-hour | flights an hour, all | memory, MB |",
        "| ---: | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for row in rows:
        lines.append(
            f"| {row.workers} | {row.flights} | {row.simulated:.1f} | {row.processor:.2f} | "
            f"{row.flights_a_core_hour:.0f} | {row.flights_an_hour:.0f} | {row.memory:.0f} |"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    main()
