"""Draws on which ways to plan are compared: every set can be flown, and the table says what its rows say."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import pytest

from doorman.campaign import Campaign

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))

from suite.draw_sets import SETS, rows_of
from suite.draw_table import figures, page


@pytest.mark.parametrize("name", list(SETS))
def test_every_run_of_a_set_can_be_drawn(name: str) -> None:
    flights = Campaign(SETS[name].source, {"planner.model": "whole_body"}).flights()
    assert len(flights) >= SETS[name].runs
    drawn = [flights[run].scenario for run in range(SETS[name].runs)]
    assert all(
        scenario.contact.kind == "push" and scenario.simulation.sensors.velocity == "differenced" for scenario in drawn
    )
    assert len({scenario.simulation.door_mass for scenario in drawn}) == SETS[name].runs


def drawn(name: str) -> list:
    flights = Campaign(SETS[name].source).flights()
    return [flights[run].scenario.simulation for run in range(SETS[name].runs)]


@pytest.mark.parametrize(("name", "rate"), [("turning_wind_slow", 4.5), ("turning_wind_fast", 9.0)])
def test_the_wind_turns_either_way_and_moves_no_leaf_by_itself(name: str, rate: float) -> None:
    rates = {round(math.degrees(one.gust.turn_rate), 2) for one in drawn(name)}
    assert rates == {-rate, rate}
    for one in drawn(name):
        assert (one.gust.vehicle, one.gust.leaf, one.gust.variation) == (1.0, 1.0, 0.0)
        assert one.gust.leaf * 1.2 / 2 < one.door_friction


def test_the_other_sets_draw_what_they_say() -> None:
    assert {(one.sensors.rate, one.sensors.latency) for one in drawn("late_cameras")} == {(100.0, 0.04)}
    assert {one.door_face_offset for one in drawn("proud_face")} == {0.04}
    assert all(0.005 < math.hypot(*one.door_offset) <= 0.0201 for one in drawn("misplaced_door"))
    assert 1.0 < max(math.degrees(abs(one.door_yaw)) for one in drawn("misplaced_door")) <= 2.001
    assert all(0.5 <= one.door_stiffness <= 2.0 for one in drawn("closers"))
    assert all(1.1 <= one.door_width <= 1.14 for one in drawn("narrow_doorways"))
    assert all(10.0 <= one.door_mass <= 35.0 and one.door_friction <= 0.8 for one in drawn("small_doors"))
    assert all(one.hand.door_angle is not None for one in drawn("hands"))
    assert {one.hand.hold for one in drawn("hands")} == {0.0, 8.0}


def row(run: int, success: bool, contact: float | None, push: float | None, collisions: int = 0) -> dict:
    return {
        "run": run, "success": success, "reason": "" if success else "it fell", "error": None, "outcome": "completed",
        "final_error_deg": -0.5 * run, "summary.collisions": collisions, "summary.contact_fraction": contact,
        "summary.max_push_force_n": push, "summary.hover_to_goal_s": 20.0 + run if success else 1.0,
        "summary.planner_ms.median": 0.5 + 0.1 * run, "summary.planner_ms.p99": 2.0 + run, "summary.planner_ms.max": 9.0 - run,
    }  # fmt: skip


def test_the_table_says_what_the_rows_say() -> None:
    rows = [
        row(0, True, 0.99, 3.0),
        row(1, True, 0.97, 5.0),
        row(2, False, 0.5, 40.0, collisions=7),
        row(3, False, 0.6, 9.0),
    ]
    found = figures("hands", "lagrangian", rows_of([*rows, row(4, True, 1.0, 1.0)], 4))
    assert [found[name] for name in ("runs", "successes", "opened_untouched", "touched")] == [4, 2, 3, 1]
    assert found["contact"] == {"median": pytest.approx(0.785), "least": 0.5}
    assert found["peak_push_n"] == {"median": 7.0, "largest": 40.0}
    assert found["off_deg"] == {"median": 0.75, "largest": 1.5} and found["hover_to_goal_s"] == 20.5
    assert found["replan_ms"] == {"p50": pytest.approx(0.65), "p99": 3.5, "max": 9.0}
    text = page([figures("closers", "quasi_static", []), found])
    assert text.count("\n| a hand holds or shoves | `lagrangian` | 2 of 4 | 15 to 85 % | 3 | 1 |") == 1
    assert "closers" not in text
    assert "0.785 (0.500) | 7.0 (40.0) | 0.75 (1.5) | 20.5 | 0.65 / 3.50 / 9.00 |" in text
    assert text.endswith("run 3: it fell")


def test_flights_without_a_figure_leave_a_dash() -> None:
    failed = {"run": 0, "success": False, "reason": "x", "error": "x", "outcome": "error", "final_error_deg": None}
    text = page([figures("hands", "quasi_static", [failed])])
    assert "0 of 1" in text and "– (–)" in text
