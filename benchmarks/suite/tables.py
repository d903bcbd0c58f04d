"""Figures as tables in Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from suite.peers import ENTRIES
from suite.statistics import Row, by, column, milliseconds, ratios


def markdown(heading: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    """A table."""
    rows = [heading, ["---"] * len(heading), *lines]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows) + "\n"


def number(value: float, digits: int = 3) -> str:
    """A number with some significant digits; a dash for none."""
    if not np.isfinite(value):
        return "–"
    if value != 0.0 and not 1e-3 <= abs(value) < 1e5:
        return f"{value:.0e}"
    decimals = max(digits - 1 - int(np.floor(np.log10(abs(value)))), 0) if value else 0
    return f"{value:.{decimals}f}"


def cold(rows: Sequence[Row], keys: Sequence[str] = ("task", "state")) -> str:
    """Cold solves by solver: times, iterations, how many states were solved, ratios to doorman."""
    heading = [
        "solver",
        "solved",
        "ms, median",
        "ms, worst",
        "iterations, median / most",
        "× doorman, median",
        "× doorman, least",
    ]
    lines = []
    for name, own in by(rows, "solver").items():
        solved = [row for row in own if row["solved"]]
        times, iterations, ratio = milliseconds(solved), column(solved, "iterations"), ratios(rows, name, keys)
        lines.append(
            [
                ENTRIES[name].label, f"{len(solved)} of {len(own)}", number(_median(times)), number(_most(times)),
                f"{number(_median(iterations))} / {number(_most(iterations))}",
                *(["1", "1"] if name == "doorman" else [number(_median(ratio)), number(_least(ratio))]),
            ]
        )  # fmt: skip
    return markdown(heading, lines)


def replan_times(rows: Sequence[Row], cold_caches: Sequence[Row] = ()) -> str:
    """Times of single iterations by solver.

    Args:
        rows: Of flights in which a solver makes all its steps in a row.
        cold_caches: Of one in which the solvers take turns after every step.
    """
    heading = ["solver", "ms, median", "ms, p99", "ms, max", "× doorman", "p99, interrupted calls too", "max"]
    heading += ["ms, median, caches cold", "max"] if cold_caches else []
    good = [row for row in rows if "seconds" in row]
    cold_times = {name: milliseconds(_uninterrupted(own)) for name, own in by(cold_caches, "solver").items()}
    times = {name: milliseconds(_uninterrupted(own)) for name, own in by(good, "solver").items()}
    ours, lines = _median(times.get("doorman", [])), []
    for name, own in by(good, "solver").items():
        median = _median(times[name])
        all_times = milliseconds(own)
        figures = [median, _p99(times[name]), _most(times[name]), median / ours, _p99(all_times), _most(all_times)]
        figures += [f(cold_times.get(name, [])) for f in (_median, _most)] if cold_caches else []
        lines.append([ENTRIES[name].label, *map(number, figures)])
    return markdown(heading, lines)


def replan_quality(rows: Sequence[Row]) -> str:
    """What single iterations are worth: suboptimality, violation, gaps of the dynamics."""
    heading = [
        "solver", "suboptimality, median", "worst", "violation, worst", "gap of the dynamics, worst", "iterations, most",
        "not usable",
    ]  # fmt: skip
    lines = []
    for name, own in by([row for row in rows if "seconds" in row], "solver").items():
        usable = [row for row in own if row["usable"]]
        gaps = np.abs(column(usable, "gap"))
        worst = [_most(gaps), *(_most(column(usable, key)) for key in ("violation", "defect", "iterations"))]
        count = f"{len(own) - len(usable)} of {len(own)}"
        lines.append([ENTRIES[name].label, number(_median(gaps)), *map(number, worst), count])
    return markdown(heading, lines)


OUTCOMES = (
    "converged",
    "another local minimum",
    "holds, stopped early",
    "holds, less optimal than it says",
    "on the way back, and said so",
    "failed and said so",
    "claims to hold, does not",
    "exception",
)  # fmt: skip


def perturbed(rows: Sequence[Row]) -> str:
    """Outcomes of perturbed starts by solver."""
    heading = ["solver", "starts", *OUTCOMES, "ms, median", "ms, p99", "ms, worst"]
    lines = []
    for name, own in by(rows, "solver").items():
        counts = [str(sum(row["outcome"] == outcome for row in own)) for outcome in OUTCOMES]
        times = milliseconds(own)
        figures = [number(_median(times)), number(_p99(times)), number(_most(times))]
        lines.append([ENTRIES[name].label, str(len(own)), *counts, *figures])
    return markdown(heading, lines)


def recovery(rows: Sequence[Row], limit: float = 0.05) -> str:
    """Starts outside the constraints: after how many nodes doorman's plans are back inside."""
    ours = [row for row in rows if row["solver"] == "doorman"]
    heading = ["start violates by", "starts", "inside from the first node on", "later", "never, or no plan"]
    lines = []
    for low, high, name in (
        (0.0, limit, f"up to {100 * limit:g} cm"),
        (limit, np.inf, f"more than {100 * limit:g} cm"),
    ):
        group = [row for row in ours if low < row["outside"] <= high]
        usable = [row for row in group if row.get("usable") and row["violation"] <= 1e-6]
        at_once = sum(row["recovered_at"] == 1 for row in usable)
        figures = [len(group), at_once, len(usable) - at_once, len(group) - len(usable)]
        lines.append([name, *map(str, figures)])
    return markdown(heading, lines)


def sizes(rows: Sequence[Row], key: str, title: str) -> str:
    """Cold solves by size: median time of every solver, how many it solves, and doorman's time per node and iteration."""
    names = list(by(rows, "solver"))
    heading = [title, *(f"{ENTRIES[name].label}, ms" for name in names), "doorman, µs per node and iteration"]
    lines = []
    for size, own in by(rows, key).items():
        cells = []
        for name in names:
            mine = [row for row in own if row["solver"] == name]
            solved = [row for row in mine if row["solved"]]
            share = "" if len(solved) == len(mine) else f" ({len(solved)} of {len(mine)})"
            cells.append(f"{number(_median(milliseconds(solved)))}{share}" if mine else "–")
        lines.append([str(size), *cells, number(_median(per_node([row for row in own if row["solver"] == "doorman"])))])
    return markdown(heading, lines)


def per_node(rows: Sequence[Row]) -> Any:
    """Time per node and iteration of solved rows [µs]."""
    solved = [row for row in rows if row["solved"] and row["iterations"] > 0]
    return 1e6 * np.array([row["seconds"] / (row["nodes"] * row["iterations"]) for row in solved])


def phases(seconds: dict[str, float]) -> str:
    """Parts of a replan in microseconds."""
    return markdown(["part", "µs"], [[name, number(1e6 * value)] for name, value in seconds.items()])


def push(rows: Sequence[Row], rows_of_a_node: dict[str, int], period: float = 0.01) -> str:
    """Replans of some of doorman's planners by planner, without and with noise; ratios to the last planner's medians.

    Args:
        rows: Of all flights.
        rows_of_a_node: Number of constraints and bounds by planner.
        period: Time between plans at the rate that is wanted [s].
    """
    heading = [
        "planner", "rows and bounds at a node", "noise", "ms, median", "p99", "max", "× six inequalities, median", "late",
        "not flyable",
    ]  # fmt: skip
    groups = {
        (name, noisy): [row for row in rows if (row["planner"], row["noisy"]) == (name, noisy)]
        for name in rows_of_a_node
        for noisy in (False, True)
    }
    times = {key: milliseconds(_uninterrupted(own)) for key, own in groups.items()}
    last, lines = list(rows_of_a_node)[-1], []
    for (name, noisy), own in groups.items():
        found = times[name, noisy]
        figures = [_median(found), _p99(found), _most(found), _median(found) / _median(times[last, noisy])]
        late = sum(row["seconds"] > period and not row["interrupted"] for row in own)
        counts = [f"{late} of {len(own)}", str(sum(not row["flyable"] for row in own))]
        lines.append([name, str(rows_of_a_node[name]), "yes" if noisy else "no", *map(number, figures), *counts])
    return markdown(heading, lines)


def meeting_cold(rows: Sequence[Row]) -> str:
    """Cold plans of a push at the same states, by solver; times of those that hold."""
    heading = [
        "solver",
        "holds",
        "cold ms, median",
        "worst",
        "× doorman, median",
        "× doorman, least",
        "iterations, median",
    ]
    lines = []
    for name, own in by(rows, "solver").items():
        good = [row for row in own if row["holds"]]
        times = milliseconds(good)
        ratio = [1.0] if name == "whole_body" else _ratios_of_holding(rows, name)
        figures = [_median(times), _most(times), _median(ratio), _least(ratio), _median(column(good, "iterations"))]
        lines.append([ENTRIES[name].label, f"{len(good)} of {len(own)}", *map(number, figures)])
    return markdown(heading, lines)


def _ratios_of_holding(rows: Sequence[Row], solver: str) -> Any:
    return ratios([{**row, "solved": row["holds"]} for row in rows], solver, ("state",), "whole_body")


def meeting_replans(rows: Sequence[Row]) -> str:
    """Replans of a push at the same states, by noise and solver."""
    heading = [
        "noise", "solver", "replan ms, median", "p99", "max", "× doorman", "violation, median", "worst", "gap, worst",
        "not usable",
    ]  # fmt: skip
    lines = []
    for noise, own in by(rows, "noise").items():
        times = {name: milliseconds(_uninterrupted(_solved_by(own, name))) for name in by(own, "solver")}
        for name, found in times.items():
            mine = _solved_by(own, name)
            usable = [row for row in mine if row["usable"]]
            violations = column(usable, "violation")
            figures = [_median(found), _p99(found), _most(found), _median(found) / _median(times["whole_body"])]
            figures += [_median(violations), _most(violations), _most(column(usable, "defect"))]
            share = f"{len(mine) - len(usable)} of {len(mine)}"
            lines.append([noise, ENTRIES[name].label, *map(number, figures), share])
    return markdown(heading, lines)


def against_acados(rows: Sequence[Row]) -> dict[str, float]:
    """Median time of acados' fastest row over doorman's, at the same states of a push, by noise."""
    ratios_by_noise = {}
    for noise, own in by(rows, "noise").items():
        medians = {
            name: _median(milliseconds(_uninterrupted(_solved_by(own, name)))) for name in by(own, "solver")
        }  # fmt: skip
        rivals = [median for name, median in medians.items() if name.startswith("acados") and np.isfinite(median)]
        if rivals and "whole_body" in medians:
            ratios_by_noise[str(noise)] = min(rivals) / medians["whole_body"]
    return ratios_by_noise


def _solved_by(rows: Sequence[Row], solver: str) -> list[Row]:
    """Rows of a solver that has answered."""
    return [row for row in rows if row["solver"] == solver and "seconds" in row]


def missing(missing_by_task: dict[str, dict[str, str]]) -> str:
    """Solvers that could not be set up, in their own words."""
    lines = [
        [ENTRIES[name].label, task, " ".join(error.split()).replace("|", "/")[:300]]
        for task, errors in missing_by_task.items()
        for name, error in errors.items()
    ]
    return markdown(["solver", "task", "what it says"], lines) if lines else "All others could be set up.\n"


def _uninterrupted(rows: Sequence[Row]) -> list[Row]:
    return [row for row in rows if not row["interrupted"]]


def _median(values: Any) -> float:
    return float(np.median(values)) if len(values) else float("nan")


def _p99(values: Any) -> float:
    return float(np.percentile(values, 99)) if len(values) else float("nan")


def _most(values: Any) -> float:
    return float(np.max(values)) if len(values) else float("nan")


def _least(values: Any) -> float:
    return float(np.min(values)) if len(values) else float("nan")
