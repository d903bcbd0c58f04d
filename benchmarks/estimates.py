"""Fly seeded recordings once, run the filter at the leaf on them, and print what it knows beside what was flown.

Usage: python benchmarks/estimates.py [--per-group 1] [--first 0] [--groups calm,jumps] [--set noise.wind=0.3]

Recordings stay under build/estimates: the same command goes on where it stopped. All figures are from the first to the last
touch, against the simulator's truth: error of the leaf's angle [deg], share of time in which contact is told right, error of
the normal force [N], share of time in which angle, resistance (while the leaf moves) and horizontal wind are within two of the
filter's own deviations, and slips: how many were found within 0.15 s, of how many, and how many were invented.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np  # noqa: E402
from numpy.typing import NDArray  # noqa: E402
from suite.estimate_flights import GROUPS, flights  # noqa: E402
from suite.estimate_truth import LeafTruth, slips  # noqa: E402

from doorman import flown  # noqa: E402
from doorman.control.estimation.replay import replay_leaf  # noqa: E402
from doorman.estimation.leaf.numbers import part  # noqa: E402
from doorman.model import Model  # noqa: E402
from doorman.recording import Recording  # noqa: E402

ROOT = Path(__file__).parents[1]
HEAD = """
| recording | end | angle, p50 / p95 / max | flown | contact | flown | force | flown | in: angle | torque | wind | slips | NIS |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"""


def row(name: str, recording: Recording, changes: dict[str, float]) -> str:
    """Line of the table."""
    outcome = recording.summary["outcome"]
    model = Model(flown.recorded_scenario(recording))
    found = replay_leaf(recording, model, changes)
    truth, estimate, known = recording["truth"], recording["estimate"], LeafTruth(recording, model)
    at = np.searchsorted(truth.time, found.time).clip(0, len(truth.time) - 1)
    posed = np.searchsorted(truth.time, found.pose_time - 1e-6).clip(0, len(truth.time) - 1)
    then = np.searchsorted(estimate.time, found.time).clip(0, len(estimate.time) - 1)
    touches = truth["touching"][at].astype(bool)
    if not touches.any():
        return f"| {name} | {outcome}, never touched | | | | | | | | | | | {found.mean_nis:.2f} |"
    span = slice(int(np.argmax(touches)), len(touches) - int(np.argmax(touches[::-1])))
    angle, force = truth["door_angle"][at], truth["tip_normal_force"][at]

    def errors(of: NDArray[np.float64]) -> str:
        p50, p95, most = np.percentile(np.degrees(np.abs(of - angle))[span], (50, 95, 100))
        return f"{p50:.2f} / {p95:.2f} / {most:.2f}"

    def right(said: NDArray[np.bool_]) -> str:
        return f"{np.mean((said == touches)[span]):.3f}"

    def rms(of: NDArray[np.float64]) -> str:
        return f"{np.sqrt(np.mean((of - force)[span] ** 2)):.2f}"

    def inside(error: NDArray[np.float64], deviation: NDArray[np.float64], counts: NDArray[np.bool_]) -> str:
        kept = (np.abs(error) < 2.0 * deviation)[span][counts[span]]
        return f"{np.mean(kept):.2f}" if len(kept) else "-"

    always = np.ones(len(at), dtype=bool)
    moves = (np.abs(truth["door_rate"][posed]) > 0.03) & truth["touching"][posed].astype(bool)
    wind = [inside(found.wind[:, k, 0] - known.wind[posed, k], found.wind[:, k, 1], always) for k in (0, 1)]
    cells = [
        name, outcome, errors(found.joint), errors(estimate["state"][then, 3]), right(found.touching > 0.5),
        right(estimate["touching"][then].astype(bool)), rms(found.normal_force[:, 0]), rms(estimate["normal_force"][then]),
        inside(part(found.mean, "joint") - truth["door_angle"][posed], part(found.deviations, "joint"), always),
        inside(part(found.mean, "resistance") - known.resistance[posed], part(found.deviations, "resistance"), moves),
        " ".join(wind),
        slips(known, found), f"{found.mean_nis:.2f}",
    ]  # fmt: skip
    return f"| {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--per-group", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first recording of each group")
    parser.add_argument("--groups", default=",".join(GROUPS))
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--folder", type=Path, default=ROOT / "build" / "estimates")
    given = parser.parse_args()
    changes = {name: float(value) for name, _, value in (each.partition("=") for each in given.set)}
    given.folder.mkdir(parents=True, exist_ok=True)
    print(HEAD)
    for flight in flights(given.first + given.per_group):
        if flight.number >= given.first and flight.group in given.groups.split(","):
            print(row(flight.name, flight.recording(given.folder), changes), flush=True)


if __name__ == "__main__":
    main()
