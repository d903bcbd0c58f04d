"""Fly the same draws with and without a sensor of the door, and sensors that fail; print a table of both.

Usage: python benchmarks/measured_door.py [--share 0.5] [--only faults] [--folder build/measured_door] [--report]

One process flies everything, set by set in rounds, so that what is there at any time is comparable. What is flown stays in the
folder, one file a flight: the same command goes on where it stopped.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import doorman
from doorman.campaign import Campaign
from doorman.campaign.judgement import final_error, judge
from doorman.recording import Recording

ROOT = Path(__file__).parents[1]
TURNING, CLOSERS = (
    str(ROOT / "benchmarks" / "draws" / name) for name in ("turning_wind_fast.toml", "grip_closers.toml")
)
GUST, SENSOR = "simulation.gust.", "simulation.door_sensor."
SENSORS = "cameras", "tags", "none"
FAULTS = "freeze", "jump", "late", "upside_down", "wrong_object", "dies"
FAILING = 20
"""Flights whose sensor fails."""
AT_ONCE = 2
"""Draws of a set in each round."""


@dataclass(frozen=True)
class DrawSet:
    """Runs of a campaign, with keys of their own."""

    words: str
    source: str
    runs: int
    keys: dict[str, Any]


SETS = {
    "push_campaign": DrawSet("unknown doors, wind, closers (`push_campaign`)", "push_campaign", 20, {}),
    "jumps": DrawSet("the same, wind that jumps", "push_campaign", 12, {GUST + "jump_rate": 0.1}),
    "turns": DrawSet("wind of 1 N that turns by 20°/s", TURNING, 8, {GUST + "turn_rate": math.radians(20.0)}),
    "rough": DrawSet("an ordinary hall (`reality_rough`)", "reality_rough", 12, {}),
    "grips": DrawSet("grips, closers up to 2 N m/rad", CLOSERS, 20, {}),
}  # fmt: skip


@dataclass(frozen=True)
class Flight:
    """One draw, flown with one sensor."""

    group: str
    run: int
    sensor: str
    keys: dict[str, Any]

    @property
    def file(self) -> str:
        return f"{self.group}_{self.run:02d}_{self.sensor}.json"


def flights(share: float) -> Iterator[Flight]:
    """All, in rounds, one sensor after the other; those without one come last."""
    for sensor in SENSORS:
        for begin in range(0, max(one.runs for one in SETS.values()), AT_ONCE):
            for name, one in SETS.items():
                for run in range(begin, min(begin + AT_ONCE, math.ceil(share * one.runs))):
                    yield Flight(name, run, sensor, one.keys | {SENSOR + "kind": sensor})
            for number in range(begin, min(begin + AT_ONCE, math.ceil(share * FAILING))):
                yield failing(number)


def failing(number: int) -> Flight:
    """A push whose cameras or tags fail in one way, before the touch or in the swing."""
    draw = np.random.default_rng([71, number])
    fault, kind = FAULTS[number % len(FAULTS)], SENSORS[number // len(FAULTS) % 2]
    opening = float(draw.uniform(-0.2, 1.0))  # below zero: from the start on
    keys = {SENSOR + "kind": kind, SENSOR + "fault": fault, SENSOR + "fault_opening": max(0.0, opening)}
    return Flight("faults", number, f"{kind}_{fault}", keys)


def fly(flight: Flight) -> dict[str, Any]:
    """Figures of one flight."""
    source = "push_campaign" if flight.group == "faults" else SETS[flight.group].source
    drawn = Campaign(source).flight(flight.run)
    scenario, begun = drawn.scenario.replace(**flight.keys), time.monotonic()
    recording = doorman.simulate(scenario, seed=drawn.draw.seed, force=True)
    summary, judged = recording.summary, judge(recording.summary)
    told = [str(words) for words in recording["event"]["message"]] if "event" in recording else []
    return {
        "success": judged.success, "safe": judged.safe, "reason": judged.reason, "collisions": summary["collisions"],
        "outcome": summary["outcome"], "opened": summary["opened"], "final_error": final_error(summary),
        "time_to_open": summary["time_to_open_s"], "told": told, "errors": errors(recording),
        "drawn": drawn.draw.values, "seconds": time.monotonic() - begun,
    }  # fmt: skip


def errors(recording: Recording) -> list[float]:
    """Median, 95th percentile and largest of the estimated angle's error while the tip is on the leaf [deg]."""
    truth, estimate = recording["truth"], recording["estimate"]
    count = min(len(truth.time), len(estimate.time))
    off = np.degrees(np.abs(estimate["state"][:count, 3] - truth["door_angle"][:count]))
    on = truth["touching"][:count].astype(bool)
    off = off[on] if on.any() else off
    return [float(np.median(off)), float(np.percentile(off, 95)), float(off.max())]


def table(folder: Path) -> str:
    """Markdown of what is there."""
    rows = [
        "| draws | sensor | success | nothing touched | estimated angle off, median / p95 | final angle off, most | opens in |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    failed = []
    for name, one in SETS.items():
        for sensor in SENSORS:
            found = {path.stem: json.loads(path.read_text()) for path in sorted(folder.glob(f"{name}_*_{sensor}.json"))}
            if not found:
                continue
            rows.append(line(one.words if sensor == SENSORS[0] else "", sensor, list(found.values())))
            failed += [f"- {stem}: {row['reason']}" for stem, row in found.items() if not row["success"]]
    lies = {path.stem: json.loads(path.read_text()) for path in sorted(folder.glob("faults_*.json"))}
    if lies:
        rows.append(line("a sensor that fails", "cameras, tags", list(lies.values())))
        failed += [f"- {stem}: {row['reason']} {row['told']}" for stem, row in lies.items() if not row["success"]]
        failed += [
            f"- {stem}: not told" for stem, row in lies.items() if not any("any more" in one for one in row["told"])
        ]
    return "\n".join([*rows, "", *failed])


def line(words: str, sensor: str, found: list[dict[str, Any]]) -> str:
    middle = np.median([row["errors"][:2] for row in found], axis=0)
    times = [row["time_to_open"] for row in found if row["time_to_open"] is not None]
    cells = (
        words, sensor, f"{sum(row['success'] for row in found)} of {len(found)}",
        f"{sum(not row['collisions'] for row in found)} of {len(found)}", f"{middle[0]:.2f}° / {middle[1]:.2f}°",
        f"{max((abs(row['final_error']) for row in found if row['success']), default=math.nan):.2f}°",
        f"{np.median(times):.1f} s" if times else "–",
    )  # fmt: skip
    return f"| {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--share", type=float, default=1.0, help="of each set's draws")
    parser.add_argument("--only", choices=[*SETS, "faults"], help="one set")
    parser.add_argument("--folder", type=Path, default=ROOT / "build" / "measured_door")
    parser.add_argument("--report", action="store_true", help="fly nothing")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    for flight in [] if arguments.report else flights(arguments.share):
        file = arguments.folder / flight.file
        if arguments.only in (None, flight.group) and not file.exists():
            row = fly(flight)
            file.write_text(json.dumps(row), encoding="utf-8")
            print(f"{flight.file}: {row['reason'] or 'opened'} ({row['seconds']:.0f} s)", flush=True)
    print(table(arguments.folder))


if __name__ == "__main__":
    main()
