"""The page of benchmarks, from raw figures."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture
def report(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setattr(sys, "path", [str(Path(__file__).parents[2] / "benchmarks"), *sys.path])
    from suite import report

    return report


def calls(solver: str, *milliseconds: float) -> list[dict[str, Any]]:
    return [
        {"solver": solver, "seconds": 1e-3 * ms, "interrupted": False, "usable": True, "gap": 1e-7, "violation": 0.0,
         "defect": 0.0, "iterations": 1}
        for ms in milliseconds
    ]  # fmt: skip


def test_headline_names_the_tuned_row_maxima_and_times_in_flight(report: Any) -> None:
    warm = [*calls("doorman", 0.05, 0.06, 0.4), *calls("hpipm_tuned", 1.8, 1.8, 1.8), *calls("hpipm", 2.4, 2.4, 2.4)]
    results = {
        "replans": {"rows": warm, "cold_caches": calls("doorman", 0.16, 0.17, 0.9)},
        "control_loop": {"rows": [{"scenario": "paper", "solve": {"median": 0.17e-3, "max": 1.57e-3}}]},
    }
    cells = [[cell.strip() for cell in line.split("|")] for line in report._at_a_glance(results).splitlines()]
    lines = {line[1]: line[2] for line in cells if len(line) > 2}
    assert lines["replan, times faster than one iteration of CasADi sqpmethod + HPIPM, tuned"] == "30.0"
    assert lines["replan, times faster than one iteration of CasADi sqpmethod + HPIPM"] == "40.0"
    assert lines["replan, ms: median / p99 / max"].split(" / ")[::2] == ["0.0600", "0.400"]
    assert lines["replan, caches cold, ms: median / max"] == "0.170 / 0.900"
    assert lines["plan in flight, `paper`, ms: median / max"] == "0.170 / 1.57"


def test_tables_of_replans_show_maxima_beside_the_tails(report: Any) -> None:
    rows = calls("doorman", 0.05, 0.06, 0.4)
    rows[2]["interrupted"] = True
    heading, _, line = report.tables.replan_times(rows, calls("doorman", 0.16, 0.9)).splitlines()
    cells = [cell.strip() for cell in line.split("|")[1:-1]]
    assert heading.count("max") == 3
    assert cells[3] == "0.0600" and cells[6] == "0.400" and cells[8] == "0.900"
