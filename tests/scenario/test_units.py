"""Units in errors, and angles that are written in degrees."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from doorman import Scenario
from doorman.exceptions import ScenarioError


@pytest.mark.parametrize(
    ("key", "value", "allowed"),
    [
        ("goal.door_angle", 30, 'less than or equal to 4.712 rad (270°); 30° are 0.5236 rad, or "30 deg"'),
        ("start.attitude", [0.0, 3.0, 0.0], 'less than 1.571 rad (90°); 3° are 0.05236 rad, or "3 deg"'),
        ("mission.hover_distance", 0, "greater than 0 m"),
        ("door.friction", -0.1, "greater than or equal to 0 N m"),
        ("mission.attempts", 11, "less than or equal to 10"),
    ],
)
def test_the_error_of_a_range_has_its_unit(key: str, value: Any, allowed: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        Scenario.load("paper", {key: value})
    assert str(caught.value.field).startswith(key)
    assert caught.value.allowed == allowed


@pytest.mark.parametrize("text", ["30 deg", "30deg", "30°", " 3e1 ° "])
def test_an_angle_may_be_written_in_degrees(text: str) -> None:
    assert Scenario.load("paper", {"goal.door_angle": text}).goal.door_angle == pytest.approx(math.radians(30))


def test_angles_in_lists_and_files_may_be_in_degrees(tmp_path: Path) -> None:
    path = tmp_path / "task.toml"
    path.write_text('[start]\nopening = "10 deg"\narm = ["-4°", 0.1, "5 deg", 0]\n[door]\nclosed = "90 deg"\n')
    scenario = Scenario.load(path)
    assert scenario.start.opening == pytest.approx(math.radians(10))
    assert scenario.start.arm == pytest.approx((math.radians(-4), 0.1, math.radians(5), 0.0))
    assert scenario.door.closed == pytest.approx(math.pi / 2)


@pytest.mark.parametrize("key", ["door.friction", "mission.hover_distance", "goal.duration", "door.damping"])
def test_what_is_no_angle_takes_no_degrees(key: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        Scenario.load("paper", {key: "3 deg"})
    assert caught.value.field == key
