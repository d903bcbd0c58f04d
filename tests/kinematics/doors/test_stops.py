"""Where a leaf shuts no farther: the end of its joint in the URDF, or closed if a closer presses it there."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Literal

import pytest
from urdf_variants import DOOR, write_edited

from doorman.kinematics.doors.door import Door
from doorman.scenario import DoorSection

CLOSED = 0.5 * math.pi


@pytest.mark.parametrize(
    ("side", "lower", "upper", "stop"),
    [("push", -1.5, 1.5708, CLOSED), ("push", -1.5, 1.7, 1.7), ("pull", 1.45, 3.1, 1.45), ("pull", -1.5, 1.7, 1.442)],
)
def test_a_leaf_stops_where_its_joint_ends(
    side: Literal["push", "pull"], lower: float, upper: float, stop: float, tmp_path: Path
) -> None:
    text = '<limit lower="-1.5" upper="1.5708"'
    urdf = write_edited(tmp_path / "door.urdf", DOOR, (text, f'<limit lower="{lower}" upper="{upper}"'))
    door = Door(urdf, DoorSection(closed=CLOSED), side)
    assert door.stop == pytest.approx(stop, abs=1e-3)
    assert door.at_its_stop(stop) and door.at_its_stop(CLOSED) is (abs(stop - CLOSED) < 0.01)
    assert door.stop in (door.lower_limit, door.upper_limit)
    pressed = Door(urdf, DoorSection(closed=CLOSED, preload=1.0), side)
    assert pressed.at_its_stop(CLOSED) and pressed.stop in (pressed.lower_limit, pressed.upper_limit)


def test_a_joint_without_limits_has_no_stop_where_it_is_closed(tmp_path: Path) -> None:
    urdf = write_edited(tmp_path / "door.urdf", DOOR, ('type="revolute"', 'type="continuous"'))
    assert not Door(urdf, DoorSection(closed=CLOSED)).at_its_stop(CLOSED)
