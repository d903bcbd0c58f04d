"""`doorman replay`: whether the plans of a recorded run come out the same."""

from __future__ import annotations

import math

from doorman.cli.command import LOOK, command
from doorman.cli.options import Json, Run

_SHOWN = 10
"""Differing plans that are listed on the terminal."""


@command(LOOK)
def replay(run: Run = None, as_json: Json = False) -> int:
    """Solve every plan of a recorded run again, and compare it with the recorded plan bit by bit.

    The planner of the recorded scenario solves each plan from the recorded state and the recorded estimate of the door. Plans
    with a warm start in flight have one here too. Another processor, or another version of doorman, NumPy or Numba, may round
    differently.

    The exit status is 0 if states, inputs, cost, iterations and status of every plan agree to the bit, 1 if not. The command
    compares states with their recorded 32 bits. It does not compare plans that a time limit cut short in flight, and their
    warm-started successors.
    """
    from doorman.cli.recordings.recorded import loaded_run, recorded_scenario
    from doorman.cli.recordings.replayed import replay_plans
    from doorman.cli.terminal.display import print_result
    from doorman.planning.planner import Planner

    file, recording = loaded_run(run, as_json)
    found = replay_plans(recording, Planner(recorded_scenario(recording, file)))
    more = len(found.differences) - _SHOWN
    lines = [*map(str, found.differences[:_SHOWN]), *([f"and {more} more"] if more > 0 else []), str(found)]
    differences = [
        {"plan": one.plan, "time": one.time,
         "fields": {name: value if math.isfinite(value) else None for name, value in one.fields.items()}}
        for one in found.differences
    ]  # fmt: skip
    counts = {"plans": found.plans, "cold": found.cold, "not_compared": found.not_compared}
    print_result(as_json, {"identical": found.identical, **counts, "differences": differences}, lines)
    return 0 if found.identical else 1
