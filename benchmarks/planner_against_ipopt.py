"""Cold plans and replans against CasADi with IPOPT on the same problem and states, in one run.

Usage: python benchmarks/planner_against_ipopt.py [--states 31] [--no-compile]
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "ocp"))
from interior_point import InteriorPointReference  # noqa: E402 (the tests' independent solution is the rival)

import doorman  # noqa: E402


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--states", type=int, default=31, help="states along the closed loop")
    parser.add_argument("--no-compile", action="store_true", help="do not compile IPOPT's functions")
    arguments = parser.parse_args()
    scenario = doorman.Scenario.load("paper", {"planner.margin": 0.0})
    planner = doorman.Planner(scenario)
    loop = closed_loop(planner, 150)
    chosen = [loop[i] for i in np.linspace(0, len(loop) - 1, arguments.states).astype(int)]
    with tempfile.TemporaryDirectory() as folder:
        options = {} if arguments.no_compile else compiled(folder)
        rival = InteriorPointReference(planner.model, options=options)
        rival.solve(chosen[0])
        rows = [compare(planner, rival, state) for state in chosen]
        del rival  # removes its compiled files before the folder goes
    warm = replans(planner, loop)
    cold, interior, gap, iterations = (np.array(column) for column in zip(*rows, strict=True))
    print(f"{'':34}{'median':>10}{'p90':>10}{'max':>10}")
    for name, values in (("IPOPT [ms]", interior), ("cold plan [ms]", cold), ("replan [ms]", warm)):
        print(
            f"{name:34}{np.median(values) * 1e3:10.3f}{np.percentile(values, 90) * 1e3:10.3f}{values.max() * 1e3:10.3f}"
        )
    counts = (np.median(iterations), np.percentile(iterations, 90), iterations.max())
    print(f"{'iterations of a cold plan':34}" + "".join(f"{count:10.0f}" for count in counts))
    ratios = interior / cold
    print(f"IPOPT / cold plan: median {np.median(ratios):.1f}, worst {ratios.min():.1f}")
    print(f"IPOPT / replan:    {np.median(interior) / np.median(warm):.1f} (medians)")
    print(f"largest relative difference in cost: {np.abs(gap).max():.1e}")


def closed_loop(planner: doorman.Planner, steps: int) -> list[np.ndarray]:
    """States that the planner passes through when its plans come true."""
    states = [planner.model.start_state]
    plan = planner.plan(states[0])
    for _ in range(steps):
        states.append(plan.states[1])
        plan = planner.replan(states[-1])
    return states


def compare(
    planner: doorman.Planner, rival: InteriorPointReference, state: np.ndarray
) -> tuple[float, float, float, int]:
    """Best of three of both solvers, in turn; difference in cost; our iterations."""
    ours, theirs = [], []
    for _ in range(3):
        ours.append(timed(lambda: planner.plan(state)))
        theirs.append(timed(lambda: rival.solve(state)))
    plan, reference = ours[0][1], theirs[0][1]
    gap = (plan.cost - reference.cost) / reference.cost
    return min(t for t, _ in ours), min(t for t, _ in theirs), gap, plan.iterations


def replans(planner: doorman.Planner, loop: list[np.ndarray]) -> np.ndarray:
    """Times of replans along the loop."""
    planner.plan(loop[0])
    return np.array([timed(lambda state=state: planner.replan(state))[0] for state in loop[1:]])


def timed(call: Callable[[], Any]) -> tuple[float, Any]:
    started = time.perf_counter()
    result = call()
    return time.perf_counter() - started, result


def compiled(folder: str) -> dict[str, Any]:
    """Options that make CasADi generate C for IPOPT's functions and compile it."""
    return {
        "jit": True,
        "compiler": "shell",
        "jit_options": {"flags": ["-O2"], "directory": folder + "/", "verbose": False},
    }


if __name__ == "__main__":
    main()
