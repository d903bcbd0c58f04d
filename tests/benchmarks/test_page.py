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


def meeting(solver: str, noise: str, *milliseconds: float) -> list[dict[str, Any]]:
    return [{**row, "noise": noise} for row in calls(solver, *milliseconds)]


def test_headline_sets_doorman_against_the_fastest_row_of_acados(report: Any) -> None:
    rows = [*meeting("whole_body", "none", 0.2, 0.2, 0.3), *meeting("acados", "none", 1.2, 1.2)]
    rows += meeting("acados_slack", "none", 2.0)
    rows[2]["interrupted"] = True
    replans = {
        "rows": [*calls("doorman", 0.05), *calls("acados_door", 0.5)],
        "cold_caches": [*calls("doorman", 0.2), *calls("acados_door", 0.8)],
    }
    headline = report._at_a_glance({"replans": replans, "push": {"replans": rows}})
    cells = [[cell.strip() for cell in line.split("|")] for line in headline.splitlines()]
    lines = {line[1]: line[2] for line in cells if len(line) > 2}
    assert lines["replan, times faster than one iteration of acados"] == "10.0"
    assert lines["replan, caches cold, times faster than acados"] == "4.00"
    assert lines["push, replan, noise none: times faster than acados"] == "6.00"


def test_cold_plans_of_a_push_that_do_not_hold_have_no_time(report: Any) -> None:
    rows = [
        {"solver": solver, "state": state, "seconds": 1e-3 * ms, "holds": holds, "iterations": 5}
        for solver, state, ms, holds in (
            ("whole_body", 0, 1.0, True), ("whole_body", 1, 2.0, True), ("acados", 0, 9.0, True), ("acados", 1, 0.1, False)
        )
    ]  # fmt: skip
    line = report.tables.meeting_cold(rows).splitlines()[-1]
    assert [cell.strip() for cell in line.split("|")[2:7]] == ["1 of 2", "9.00", "9.00", "9.00", "9.00"]
