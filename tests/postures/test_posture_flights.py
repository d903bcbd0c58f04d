"""Proposed postures, flown: the door ends where it should, with nothing touched."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from postures_of import write_wrist

from doorman import Model, Scenario, simulate


def assert_opens(source: str, duration: float | None = None, **overrides: Any) -> None:
    model = Model(Scenario.load(source, {key.replace("__", "."): value for key, value in overrides.items()}))
    summary = simulate(model, duration, seed=2).summary
    assert summary is not None
    assert summary["opened"] and summary["collisions"] == 0, summary
    assert abs(summary["final_door_angle_deg"] - math.degrees(model.goal_angle)) < 1.0
    assert summary["min_clearance_m"] > 0.0
    assert summary["max_constraint_violation_m"] <= 0.01
    assert duration or summary["outcome"] == "completed"


def test_a_door_opens_to_45_degrees() -> None:
    """With the paper's posture turned with the leaf, the disc would overlap the latch jamb there."""
    assert_opens("paper", 9.0, goal__door_angle=0.785, mission__start="contact")


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [5.0, 30.0, 45.0, 75.0])
@pytest.mark.parametrize("kind", ["paper", "push"])
def test_a_door_opens_to_any_angle(kind: str, degrees: float) -> None:
    assert_opens(kind, goal__door_angle=math.radians(degrees))


@pytest.mark.slow
@pytest.mark.parametrize("axis", ["0 -1 0", "0 0 1"])
def test_five_joints_open_a_door(tmp_path: Path, axis: str) -> None:
    urdf = str(write_wrist(tmp_path / "wrist.urdf", axis))
    for degrees in (20.0, 45.0):
        assert_opens("paper", vehicle__urdf=urdf, goal__door_angle=math.radians(degrees))
