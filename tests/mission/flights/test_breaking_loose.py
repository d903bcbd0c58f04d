"""Doors that a seal or a latch holds over the first degrees, flown."""

from __future__ import annotations

from typing import Any

import pytest

from doorman import Scenario, simulate

pytestmark = pytest.mark.slow

LIGHT = {"door_mass": 8.0, "door_friction": 0.3, "door_damping": 0.0}
STUBBORN = {"door_friction": 1.0, "door_damping": 1.0}


def flown(scenario: str, seed: int, **simulation: Any) -> dict[str, Any]:
    keys = {f"simulation.{name}": value for name, value in simulation.items()}
    summary = simulate(Scenario.load(f"shipped:{scenario}", keys), seed=seed).summary
    assert summary is not None and summary["collisions"] == 0 and summary["max_push_force_n"] <= 12.5
    return summary


@pytest.mark.parametrize("true", [LIGHT, STUBBORN, {"door_stiffness": 1.0, "gust.vehicle": 1.0, "gust.leaf": 1.0}])
def test_a_sealed_door_is_pushed_open_and_not_flung(true: dict[str, float]) -> None:
    summary = flown("push", 2, door_seal=4.0, **true)
    assert summary["outcome"] == "completed" and abs(summary["final_error"]) < 2.0


@pytest.mark.parametrize("true", [{}, {"door_mass": 7.0}])
def test_a_sealed_door_is_gripped_open_and_the_seal_is_no_friction(true: dict[str, float]) -> None:
    summary = flown("paper", 1, door_seal=4.0, **true)
    assert summary["outcome"] == "completed" and abs(summary["final_error"]) < 1.0
    assert summary["estimates"]["torque"]["value"] < 1.0


def test_a_latch_snaps_open() -> None:
    summary = flown("push_left", 6, door_latch=4.0)
    assert summary["outcome"] == "completed" and abs(summary["final_error"]) < 2.0


def test_a_bolted_door_is_pushed_as_hard_as_allowed_and_left_alone() -> None:
    summary = flown("push", 4, door_latch=100.0)
    assert summary["outcome"] == "given up" and "does not move on" in summary["reason"]
    assert summary["max_push_force_n"] > 9.0 and summary["attempts"] == 1
