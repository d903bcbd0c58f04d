"""Table of a comparison: one line a set and model, from the rows of their campaigns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from doorman.campaign.report.figures import numbers, wilson_interval
from doorman.campaign.results import SUMMARY, Row
from doorman.summary import COMPLETED
from suite.draw_sets import SETS

_HEAD = (
    "draws", "model", "success", "95 %", "opened, untouched", "touched", "on the leaf, median (least)",
    "peak push [N], median (largest)",
    "off [°], median (largest)", "hover to goal [s]", "replan p50 / p99 / max [ms]",
)  # fmt: skip


def figures(name: str, model: str, rows: Sequence[Row]) -> dict[str, Any]:
    """Figures of one set flown with one model.

    Times to the goal are of successes; all others of all flights. A flight that opened its door without touching anything is a
    success unless it lost the leaf for long or pushed it hard. A flight's replans have a median and a 99th percentile: the
    table has the flights' medians of both, and the longest replan of all.

    Args:
        name: Of the set.
        model: Value of `planner.model`.
        rows: Of its campaign.

    Returns:
        The figures; None where no flight has one.
    """
    opened = [row for row in rows if row["success"]]
    off = np.abs(numbers(rows, "final_error_deg"))
    return {
        "set": name,
        "model": model,
        "runs": len(rows),
        "successes": len(opened),
        "interval_95": wilson_interval(len(opened), len(rows)),
        "opened_untouched": sum(row["outcome"] == COMPLETED and not row.get(f"{SUMMARY}collisions") for row in rows),
        "touched": sum(bool(row.get(f"{SUMMARY}collisions")) for row in rows),
        "errors": sum(row["error"] is not None for row in rows),
        "contact": _of(numbers(rows, f"{SUMMARY}contact_fraction"), median=np.median, least=np.min),
        "peak_push_n": _of(numbers(rows, f"{SUMMARY}max_push_force_n"), median=np.median, largest=np.max),
        "off_deg": _of(off, median=np.median, largest=np.max),
        "hover_to_goal_s": _of(numbers(opened, f"{SUMMARY}hover_to_goal_s"), median=np.median)["median"],
        "replan_ms": {
            "p50": _of(numbers(rows, f"{SUMMARY}planner_ms.median"), median=np.median)["median"],
            "p99": _of(numbers(rows, f"{SUMMARY}planner_ms.p99"), median=np.median)["median"],
            "max": _of(numbers(rows, f"{SUMMARY}planner_ms.max"), largest=np.max)["largest"],
        },
        "reasons": {row["run"]: row["reason"] for row in rows if not row["success"]},
    }


def page(found: Sequence[dict[str, Any]]) -> str:
    """The comparison as Markdown: the table, and why flights failed.

    Args:
        found: As `figures` gives them.
    """
    flown = [one for one in found if one["runs"]]
    lines = [_line(_HEAD), _line(["---"] * len(_HEAD)), *(_line(_cells(one)) for one in flown)]
    failed = [
        f"- {SETS[one['set']].words}, {one['model']}, run {run}: {reason}"
        for one in flown
        for run, reason in one["reasons"].items()
    ]
    return "\n".join([*lines, "", *failed])


def _cells(one: dict[str, Any]) -> list[str]:
    low, high = one["interval_95"]
    contact, push, off, replan = one["contact"], one["peak_push_n"], one["off_deg"], one["replan_ms"]
    return [
        SETS[one["set"]].words,
        f"`{one['model']}`",
        f"{one['successes']} of {one['runs']}",
        f"{100 * low:.0f} to {100 * high:.0f} %",
        str(one["opened_untouched"]),
        str(one["touched"]) + (f" ({one['errors']} errors)" if one["errors"] else ""),
        f"{_text(contact['median'], 3)} ({_text(contact['least'], 3)})",
        f"{_text(push['median'], 1)} ({_text(push['largest'], 1)})",
        f"{_text(off['median'], 2)} ({_text(off['largest'], 1)})",
        _text(one["hover_to_goal_s"], 1),
        " / ".join(_text(replan[key], 2) for key in ("p50", "p99", "max")),
    ]


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _text(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


def _of(values: np.ndarray, **wanted: Callable[[np.ndarray], Any]) -> dict[str, float | None]:
    return {name: float(function(values)) if len(values) else None for name, function in wanted.items()}
