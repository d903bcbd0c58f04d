"""Proposed postures, flown: the door ends where it should, with nothing touched."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from completed_flights import completed
from postures_of import write_wrist


def opens(source: str, degrees: float, **keys: str) -> None:
    summary, _ = completed(source, {"goal.door_angle": math.radians(degrees), **keys}, 2, final_error=1.0)
    assert summary["min_clearance_m"] > 0.0 and summary["max_constraint_violation_m"] <= 0.01


def test_a_door_opens_to_45_degrees() -> None:
    """With the paper's posture turned with the leaf, the disc would overlap the latch jamb there."""
    opens("paper", 45.0, **{"mission.start": "contact"})


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [5.0, 30.0, 45.0, 75.0])
@pytest.mark.parametrize("kind", ["paper", "push"])
def test_a_door_opens_to_any_angle(kind: str, degrees: float) -> None:
    opens(kind, degrees)


@pytest.mark.slow
@pytest.mark.parametrize("axis", ["0 -1 0", "0 0 1"])
def test_five_joints_open_a_door(tmp_path: Path, axis: str) -> None:
    urdf = str(write_wrist(tmp_path / "wrist.urdf", axis))
    for degrees in (20.0, 45.0):
        opens("paper", degrees, **{"vehicle.urdf": urdf})
