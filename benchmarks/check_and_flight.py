"""Compare the findings of the check that need no flight with the flight, on draws of the shipped scenarios.

Usage: python benchmarks/check_and_flight.py [--draws 100] [--seed 1] [--out build/check_and_flight.jsonl]

A draw is a shipped scenario with another start, goal, weights of the plan, thrust or mass of the leaf. It is checked as by
`doorman check --quick` and then flown, whatever the check says. A mismatch is a draw that is possible and does not open
untouched, or one that is refused and does. `doorman check` itself flies, so that it has none of the former. The reality scenarios
and the campaign are left out: no check considers wind, noise or an unknown door.

One process flies one draw after the other, each about 10 s. Draws that the file has already are not flown again. `--recheck`
checks them again, and `--show` only prints what the file has.
"""

from __future__ import annotations

import argparse
import json
import math
import time
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from doorman import Model, Scenario, simulate
from doorman.exceptions import DoormanError
from doorman.feasibility import check
from doorman.summary import verdict

SOURCES = (
    "paper", "push", "pull", "close", "cabinet", "drawer", "drawer_close", "fig4", "gate", "hatch", "paper_tilted",
    "push_left", "push_small", "push_tilted", "sliding", "through",
)  # fmt: skip
DRAWN = 0.5
"""Share of the draws that change each of start, goal, weights, thrust and mass."""


def drawn(seed: int, number: int) -> tuple[str, dict[str, Any]]:
    """Scenario and changed keys of a draw."""
    rng, source = np.random.default_rng([seed, number]), SOURCES[number % len(SOURCES)]
    model = Model(Scenario.load(f"shipped:{source}"))
    door, keys = model.door, dict[str, Any]()
    first, last = door.opening_of(model.start_angle), door.opening_of(model.goal_angle)
    changes = rng.random(5) < DRAWN
    begins, ends = rng.uniform(0.0, 0.6), rng.uniform(-0.4, 0.25)
    if changes[0]:
        keys |= {"start.door_angle": None, "start.opening": within(model, first + begins * (last - first))}
    if changes[1] and last > first:
        keys |= {"goal.door_angle": None, "goal.opening": within(model, last + ends * (last - first))}
    weights, arm = 10.0 ** rng.uniform(-1.0, 1.0, 9), model.n_arm
    paper = np.array([5.0, 5.0, 3.0, 9.0, 8.0, 0.05, *[0.1] * (arm - 1)])[: 5 + arm]
    if changes[2] and model.scenario.contact.kind == "grip":
        keys["planner.weights.state"] = (paper * weights[: 5 + arm]).round(3).tolist()
    if changes[3]:
        keys["vehicle.max_thrust"] = round(model.vehicle.max_thrust * rng.uniform(0.75, 1.3), 1)
    told, true = 10.0 ** rng.uniform(-0.4, 0.4), rng.uniform(0.7, 1.4)
    if changes[4]:
        mass = door.mass
        if model.scenario.door.urdf.startswith("hinged_door"):
            keys["door.mass"] = mass = round(mass * told, 1)
        keys["simulation.door_mass"] = round(mass * true, 1)
    return source, keys


def within(model: Model, opening: float) -> float:
    """An opening inside the joint's range, with room for what passes the goal [rad or m]."""
    most = model.door.largest_opening - 0.05 * model.door.per_angle
    return round(min(max(opening, 0.0), most), 3)


def checked(model: Model) -> dict[str, Any]:
    """Verdict of the check alone."""
    began = time.perf_counter()
    report = check(model)
    names = {
        "errors": [finding.name for finding in report.errors],
        "warnings": [finding.name for finding in report.warnings],
    }
    return {"possible": report.possible, **names, "check_s": round(time.perf_counter() - began, 1)}


def flown(seed: int, number: int) -> dict[str, Any]:
    """Verdicts of check and flight about a draw."""
    source, keys = drawn(seed, number)
    model = Model(Scenario.load(f"shipped:{source}", keys))
    row = {"draw": number, "source": source, "keys": keys} | checked(model)
    began = time.perf_counter()
    try:
        summary = simulate(model, force=True).summary or {}
    except DoormanError as error:
        return {**row, "flies": False, "words": f"failed: {error}"}
    flies, words = verdict(summary)
    row |= {"flies": flies, "words": words, "flight_s": round(time.perf_counter() - began, 1)}
    names = "outcome", "final_error", "collisions", "min_clearance_m", "max_constraint_violation_m", "duration_s"
    return row | {name: summary[name] for name in names}


def kind(row: dict[str, Any]) -> str:
    """How verdicts agree or differ."""
    if row["possible"] == row["flies"]:
        return "agree"
    if not row["possible"]:
        return "refused, flies"
    if row.get("collisions"):
        return "possible, touched"
    if row.get("outcome") == "given up":
        return "possible, given up"
    return "possible, off the goal"


def show(rows: list[dict[str, Any]]) -> None:
    """Print the mismatches by kind, and how many there are of each."""
    for row in sorted(rows, key=kind):
        if kind(row) != "agree":
            error = row.get("final_error", math.nan)
            print(f"{kind(row)} | {row['draw']} {row['source']} {json.dumps(row['keys'])}")
            print(f"    {', '.join(row['errors']) or '-'} | {error:.1f} off | {row['words']}")
    for name, count in sorted(Counter(kind(row) for row in rows).items()):
        print(f"{count:4d} {name}")
    print(
        f"{sum(row['possible'] for row in rows):4d} possible, {sum(row['flies'] for row in rows)} fly, of {len(rows)}"
    )


def main() -> None:
    """Fly what the file lacks, and show it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=100, help="how many")
    parser.add_argument("--only", type=int, nargs="+", help="these draws alone")
    parser.add_argument("--seed", type=int, default=1, help="of the draws")
    parser.add_argument("--show", action="store_true", help="fly nothing")
    parser.add_argument("--recheck", action="store_true", help="fly nothing, and check again what the file has")
    parser.add_argument("--out", type=Path, default=Path("build/check_and_flight.jsonl"), help="one line for each draw")
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    given.out.parent.mkdir(parents=True, exist_ok=True)
    known = given.out.read_text(encoding="utf-8").splitlines() if given.out.exists() else []
    rows: dict[int, dict[str, Any]] = {row["draw"]: row for row in map(json.loads, known)}
    for row in rows.values() if given.recheck else ():
        row |= checked(Model(Scenario.load(f"shipped:{row['source']}", row["keys"])))
    with given.out.open("a", encoding="utf-8") as file:
        for number in () if given.show or given.recheck else given.only or range(given.draws):
            if number not in rows:
                rows[number] = flown(given.seed, number)
                print(json.dumps(rows[number]), file=file, flush=True)
    show(list(rows.values()))


if __name__ == "__main__":
    main()
