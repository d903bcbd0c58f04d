"""Measure doorman's planner against its peers, and write the page of results.

Usage: python benchmarks/run.py [--quick] [--only cold,replans] [--peers ipopt,fatrop] [--write-docs]
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

from build_native import RECIPES, BuildError, packages  # noqa: E402
from suite import report  # noqa: E402
from suite.environment import peers_python  # noqa: E402
from suite.machine import describe  # noqa: E402
from suite.peers import ENTRIES  # noqa: E402
from suite.session import Session  # noqa: E402
from suite.standard import problems  # noqa: E402
from suite.workloads import (  # noqa: E402
    closed_loop,
    cold,
    control_loop,
    floor,
    fresh_process,
    perturbed,
    phases,
    push,
    replans,
    sizes,
)

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "build" / "benchmarks"
OURS = [name for name, entry in ENTRIES.items() if entry.ours]
PEERS = [name for name, entry in ENTRIES.items() if not entry.ours]


def main() -> None:
    arguments = parse()
    workloads = available(arguments)
    python = arguments.peers_python.absolute() if arguments.peers_python else peers_python(FOLDER / "peers")
    folder = (arguments.folder or FOLDER / ("quick" if arguments.quick else "full")).absolute()
    folder.mkdir(parents=True, exist_ok=True)
    build_natively(arguments.peers, python)
    chosen_names = [*OURS, *arguments.peers]
    door, standard, push_alone = (
        [name for name in chosen_names if ENTRIES[name].problem == problem] for problem in ("door", "standard", "push")
    )
    session = Session(folder, door, Path(sys.executable), python, arguments.core, arguments.quick)
    sessions = {"standard": replace(session, names=standard), "push": replace(session, names=[*push_alone, *standard])}
    machine = {**describe(session.python, python, arguments.core), "quick": arguments.quick}
    results: dict[str, Any] = {"machine": machine}
    try:
        for name in arguments.only:
            started = time.monotonic()
            print(f"{name} …", end=" ", flush=True)
            results[name] = workloads[name](sessions.get(name, session))
            keep({name: results[name], "machine": results["machine"], "missing": session.missing}, folder / "raw")
            print(f"{time.monotonic() - started:.0f} s", flush=True)
    finally:
        session.close()
    publish(load(folder / "raw"), ROOT / "docs" if arguments.write_docs else folder)


def build_natively(peers: list[str], python: Path) -> None:
    """Build what is not on the package index; where that fails, its peers say themselves what they miss."""
    for name, recipe in RECIPES.items():
        if any(peer.startswith(name) for peer in peers):
            try:
                recipe.build(packages(python))
            except BuildError as error:
                print(error, file=sys.stderr)


def available(arguments: argparse.Namespace) -> dict[str, Callable[[Session], dict[str, Any]]]:
    """What can be measured, in the order in which it is."""
    seconds = arguments.closed_loop_seconds or (10.0 if arguments.quick else 60.0)
    return {
        "cold": cold.measure,
        "limits": cold.measure_limited,
        "replans": replans.measure,
        "disturbed": replans.measure_disturbed,
        "perturbed": perturbed.measure,
        "doors": cold.measure_doors,
        "horizons": sizes.measure_horizons,
        "arms": sizes.measure_arms,
        "phases": phases.measure,
        "push": push.measure,
        "standard": problems.measure,
        "floor": floor.measure,
        "fresh": fresh_process.measure,
        "closed_loop": lambda session: closed_loop.measure(session, seconds),
        "control_loop": lambda session: control_loop.measure(session, seconds),
    }


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    workloads = list(available(argparse.Namespace(closed_loop_seconds=1.0, quick=True)))
    parser.add_argument("--quick", action="store_true", help="fewer states and repetitions: some minutes")
    parser.add_argument("--only", type=partial(chosen, allowed=workloads), default=workloads, help=", ".join(workloads))
    parser.add_argument("--peers", type=partial(chosen, allowed=PEERS), default=PEERS, help=", ".join(PEERS))
    parser.add_argument("--core", type=int, default=max(os.sched_getaffinity(0)), help="the solvers' core")
    parser.add_argument("--closed-loop-seconds", type=float, help="length of the real-time run: 60, quick 10")
    parser.add_argument("--peers-python", type=Path, help="interpreter that has the peers; by default one is made")
    parser.add_argument("--folder", type=Path, help="raw figures, logs and generated code")
    parser.add_argument("--write-docs", action="store_true", help="write docs/benchmarks.md and its plots")
    return parser.parse_args()


def chosen(text: str, allowed: list[str]) -> list[str]:
    names = [name.strip() for name in text.split(",") if name.strip()]
    unknown = set(names) - set(allowed)
    if unknown:
        raise argparse.ArgumentTypeError(f"unknown: {', '.join(sorted(unknown))}; there are {', '.join(allowed)}")
    return [name for name in allowed if name in names]


def keep(results: dict[str, Any], folder: Path) -> None:
    """Raw figures, one file for each workload; those of workloads that were not run now stay."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, result in results.items():
        (folder / f"{name}.json").write_text(json.dumps(result, indent=1), encoding="utf-8")


def load(folder: Path) -> dict[str, Any]:
    return {file.stem: json.loads(file.read_text(encoding="utf-8")) for file in folder.glob("*.json")}


def publish(results: dict[str, Any], folder: Path) -> None:
    """Page and plots."""
    report.draw(results, folder / "benchmarks")
    page = folder / "benchmarks.md"
    page.write_text(report.page(results), encoding="utf-8")
    print(f"Results: {page}")


if __name__ == "__main__":
    main()
