"""Fly the same draws with one planner's model after the other, and print the table that compares them.

Usage: python benchmarks/compare_plans.py [--models whole_body] [--sets proud_face,hands] [--first 6] [--report]

What is flown stays under build/draws, one campaign a model and set: the same command goes on where it stopped, a larger --first
flies what is missing, and --report prints the table of what is there.
"""

from __future__ import annotations

import argparse
import json
import sys
from functools import partial
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

from suite.draw_sets import SETS, rows_of  # noqa: E402
from suite.draw_table import figures, page  # noqa: E402

from doorman.campaign import Campaign  # noqa: E402
from doorman.campaign.running import durable_rows, run_campaign
from doorman.cli.values import parse_overrides  # noqa: E402
from doorman.exceptions import DoormanError  # noqa: E402
from doorman.scenario import Scenario  # noqa: E402

ROOT = Path(__file__).parents[1]


def main() -> None:
    arguments = parse()
    found: list[dict[str, Any]] = []
    for name in arguments.sets:
        for model in arguments.models:
            folder = arguments.folder / model / name
            if not arguments.report:
                fly(name, model, folder, arguments)
            rows = rows_of(durable_rows(folder), SETS[name].runs if arguments.first is None else arguments.first)
            found.append(figures(name, model, rows))
    print(page(found))
    arguments.folder.mkdir(parents=True, exist_ok=True)
    (arguments.folder / "table.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def fly(name: str, model: str, folder: Path, arguments: argparse.Namespace) -> None:
    """What is missing of one set with one model."""
    runs = SETS[name].runs if arguments.first is None else min(arguments.first, SETS[name].runs)
    overrides = {**parse_overrides(arguments.set), "planner.model": model}
    folder.mkdir(parents=True, exist_ok=True)

    def note(row: dict[str, Any], known: int, total: int) -> None:
        words = "opened" if row["success"] else row["reason"]
        print(f"{model} {name} {known}/{total}: run {row['run']}: {words}", file=sys.stderr, flush=True)

    run_campaign(Campaign(SETS[name].source, overrides), folder, runs, arguments.workers, on_row=note)


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", type=models, default=["whole_body"], help="values of planner.model")
    parser.add_argument("--sets", type=partial(chosen, allowed=list(SETS)), default=list(SETS), help=", ".join(SETS))
    parser.add_argument("--first", type=int, help="so many draws of every set at most; by default all")
    parser.add_argument(
        "--workers", type=int, default=1, help="flights at a time: 1, so that solve times are undisturbed"
    )
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="override of all flights")
    parser.add_argument("--folder", type=Path, default=ROOT / "build" / "draws", help="of the campaigns")
    parser.add_argument("--report", action="store_true", help="fly nothing")
    arguments = parser.parse_args()
    if arguments.first is not None and arguments.first < 1:
        parser.error("argument --first: at least 1")
    return arguments


def models(text: str) -> list[str]:
    names = [name.strip() for name in text.split(",") if name.strip()]
    for name in names:
        try:
            Scenario.load("push", {"planner.model": name})
        except DoormanError as error:
            raise argparse.ArgumentTypeError(str(error)) from error
    return names


def chosen(text: str, allowed: list[str]) -> list[str]:
    names = [name.strip() for name in text.split(",") if name.strip()]
    unknown = set(names) - set(allowed)
    if unknown:
        raise argparse.ArgumentTypeError(f"unknown: {', '.join(sorted(unknown))}; there are {', '.join(allowed)}")
    return [name for name in allowed if name in names]


if __name__ == "__main__":
    main()
