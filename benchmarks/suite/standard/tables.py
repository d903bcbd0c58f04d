"""Figures of the standard problems as tables in Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from suite.peers import ENTRIES
from suite.statistics import Row, by, column, milliseconds, ratios
from suite.tables import markdown, number

COST_TOLERANCE = 1e-4
"""Relative excess of the cost up to which a solution is not worse than IPOPT's."""

TEXT = f"""Six problems that other libraries publish, as `examples/ocp` has them; nothing is tuned to them. Every solver gets
the same perturbed starts and the same first guess: a straight line of states, and constant inputs.

| word | meaning |
| --- | --- |
| holds | dynamics, constraints and bounds hold to 1e-6 |
| not worse | holds, and costs at most {COST_TOLERANCE:g} (relative) more than what IPOPT finds from the same guess |
| better | costs less than that by more than {COST_TOLERANCE:g} |
| cold | time that the solver had the core, of solves that hold; ratios start by start, where both hold |
| replan | one iteration from the shifted plan, in closed loops, by the clock on the wall; interrupted ones by time on the core |
| violation | largest of a solution that the solver calls usable |

Each solver flies closed loops of its own plans on a disturbed plant. The first plan is its own, or IPOPT's where its own does
not hold. The plant runs between two replans, so that nobody finds its data in the cache. IPOPT and fatrop have no single
iteration."""


def report(result: Any) -> str:
    """The section of the page."""
    parts = [TEXT, f"Measured {result['when']} on {result['processor']}.", glance(result)]
    flights = by(result["flights"], "problem")
    for name, rows in by(result["rows"], "problem").items():
        size = result["sizes"][name]
        sizes = f"{size['nx']} states, {size['nu']} inputs, N = {size['horizon']}"
        title = f"### {size['title'][0].upper()}{size['title'][1:]}"
        parts.append(f"{title}\n\n`examples/ocp/{name}.py`: {sizes}.\n\n{solvers(rows, flights.get(name, []))}")
    return "\n\n".join(parts)


def glance(result: Any) -> str:
    """Every problem in one line: doorman beside the fastest compiled peer."""
    heading = [
        "problem", "cold, ms", "fastest compiled peer", "× doorman, median", "replan, ms", "fastest peer", "× doorman",
        "not worse than IPOPT", "goal reached",
    ]  # fmt: skip
    flights, lines = by(result["flights"], "problem"), []
    for name, rows in by(result["rows"], "problem").items():
        flown = flights.get(name, [])
        ours = [row for row in rows if row["solver"] == "hybrid"]
        cold, replan = _fastest_cold(rows), _fastest_replan(flown)
        own_replan, loops = replan_times(flown, "hybrid"), [row for row in flown if row["solver"] == "hybrid"]
        times = milliseconds(row for row in ours if row["holds"])
        lines.append(
            [
                result["sizes"][name]["title"], number(_median(times)), cold[0], number(cold[1]),
                number(_median(own_replan)), replan[0], number(replan[1] / _median(own_replan)),
                f"{sum(map(not_worse, ours))} of {len(ours)}",
                f"{sum(row['reached'] for row in loops)} of {len(loops)}",
            ]
        )  # fmt: skip
    return markdown(heading, lines)


def solvers(rows: Sequence[Row], flights: Sequence[Row]) -> str:
    """One problem, solver by solver."""
    heading = [
        "solver", "holds", "not worse", "better", "cold ms, median", "p99", "× doorman", "iterations, median / most",
        "violation", "replan ms, median", "p99", "goal reached",
    ]  # fmt: skip
    lines = []
    for name, own in by(rows, "solver").items():
        good = [row for row in own if row["holds"]]
        times, iterations = milliseconds(good), column(good, "iterations")
        ratio = [1.0] if name == "hybrid" else ratios(_solved(rows), name, ("start",), "hybrid")
        replans, loops = replan_times(flights, name), [row for row in flights if row["solver"] == name]
        violation = column([row for row in own if row["usable"]], "violation")
        lines.append(
            [
                ENTRIES[name].label, f"{len(good)} of {len(own)}", str(sum(map(not_worse, own))),
                str(sum(row["holds"] and row["gap"] < -COST_TOLERANCE for row in own)),
                number(_median(times)), number(_p99(times)), number(_median(ratio)),
                f"{number(_median(iterations))} / {number(max(iterations, default=np.nan))}",
                number(max(violation, default=np.nan)), number(_median(replans)), number(_p99(replans)),
                f"{sum(row['reached'] for row in loops)} of {len(loops)}" if loops else "–",
            ]
        )  # fmt: skip
    return markdown(heading, lines)


def not_worse(row: Row) -> bool:
    """Whether a solution holds and costs no more than IPOPT's."""
    return bool(row["holds"] and row["gap"] <= COST_TOLERANCE)


def replan_times(flights: Sequence[Row], solver: str) -> Any:
    """Times of a solver's replans in all its closed loops [ms]."""
    return 1e3 * np.array([second for row in flights if row["solver"] == solver for second in row.get("seconds", [])])


def _fastest_cold(rows: Sequence[Row]) -> tuple[str, float]:
    """Compiled peer with the least median ratio to doorman, among those that solve at least half of the starts."""
    found = [("–", np.inf)]
    for name, own in by(rows, "solver").items():
        if _compiled(name) and 2 * sum(row["holds"] for row in own) >= len(own):
            found.append((ENTRIES[name].label, _median(ratios(_solved(rows), name, ("start",), "hybrid"))))
    return min(found, key=lambda pair: pair[1])


def _fastest_replan(flights: Sequence[Row]) -> tuple[str, float]:
    """Compiled peer with the least median time [ms], among those whose closed loops reach the goal."""
    found = [("–", np.nan)]
    for name, own in by(flights, "solver").items():
        if _compiled(name) and 2 * sum(row["reached"] for row in own) >= len(own):
            found.append((ENTRIES[name].label, _median(replan_times(flights, name))))
    return min(found[1:] or found, key=lambda pair: pair[1])


def _compiled(name: str) -> bool:
    return ENTRIES[name].label.endswith(", C")


def _solved(rows: Sequence[Row]) -> list[Row]:
    return [{**row, "solved": row["holds"]} for row in rows]


def _median(values: Any) -> float:
    return float(np.median(values)) if len(values) else float("nan")


def _p99(values: Any) -> float:
    return float(np.percentile(values, 99)) if len(values) else float("nan")
