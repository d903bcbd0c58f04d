"""How flights go behind attitude loops that nobody told them of: a grid of lags and dead times.

    python benchmarks/attitude_loops.py [--scenarios push paper] [--seeds 1 2] [--lags ...] [--dead-times ...] [--set KEY=VALUE]

One line a flight: what came of it, the door's last angle, the loop that the hover measured, how far the vehicle sank, and what
touched what. The last line counts. `--set mission.measures=[]` flies by what is believed instead of what is measured.
"""

from __future__ import annotations

import argparse
import itertools
import math
import tomllib
from typing import Any

import numpy as np

from doorman import DoormanError, Model, Scenario
from doorman.mission import Mission
from doorman.recording import Recorder
from doorman.simulation import SimulatedBackend

LAGS, DEAD_TIMES = (0.03, 0.05, 0.1, 0.15, 0.22, 0.3), (0.0, 0.04, 0.08)
"""[s]."""


def flown(name: str, seed: int, settings: dict[str, Any]) -> tuple[str, str]:
    """Kind of outcome, and a line about it."""
    model, recorder = Model(Scenario.load(name, settings)), Recorder(None, {})
    mission, failure = Mission(model, recorder=recorder), ""
    try:
        mission.fly(SimulatedBackend(model, seed, recorder))
    except DoormanError as error:
        failure = str(error)
    recorder.close()
    recording = recorder.recording()
    truth, opened = recording["truth"], mission.outcome[0]
    pairs = {str(pair) for pair in np.asarray(truth["collision_pairs"], dtype=object) if len(pair)}
    height, last = truth["position"][:, 2], math.degrees(float(np.ravel(truth["door_angle"])[-1]))
    touched = bool(np.asarray(truth["collisions"]).any())
    refused = not opened and not np.asarray(truth["touching"]).any()
    kind = "touched" if touched else "opened" if opened else "refused" if refused else "given up"
    loop = "not measured"
    if "attitude_loop" in recording:
        found = recording["attitude_loop"]
        loop = f"{found['lag'][-1].mean():.3f} + {found['dead_time'][-1].mean():.3f} s"
    words = failure or mission.outcome[1]
    return kind, (
        f"{kind:9} door {last:6.1f}°  loop {loop}  sank {height[0] - height.min():.2f} m  {truth.time[-1]:.0f} s  "
        f"{words}  {'; '.join(sorted(pairs))[:120]}"
    )


def main() -> None:
    """Fly the grid."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenarios", nargs="+", default=["push", "paper"])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2])
    parser.add_argument("--lags", nargs="+", type=float, default=LAGS)
    parser.add_argument("--dead-times", nargs="+", type=float, default=DEAD_TIMES)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    given = parser.parse_args()
    settings = {
        key: tomllib.loads(f"x = {value}")["x"] for key, _, value in (each.partition("=") for each in given.set)
    }
    counts: dict[str, int] = {}
    for name, seed, lag, dead in itertools.product(given.scenarios, given.seeds, given.lags, given.dead_times):
        loop = {"simulation.attitude_lag": lag, "simulation.attitude_dead_time": dead}
        kind, line = flown(name, seed, {**loop, **settings})
        counts[kind] = counts.get(kind, 0) + 1
        print(f"{name} {seed}  lag {lag:.2f}  dead {dead:.2f}  {line}", flush=True)
    print(", ".join(f"{count} {kind}" for kind, count in sorted(counts.items())))


if __name__ == "__main__":
    main()
