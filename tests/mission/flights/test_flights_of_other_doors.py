"""Doors on the left, elsewhere in the world, and with a face before the axis, flown."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from urdf_variants import DOOR, write_edited, write_mirrored, write_moved

from doorman import Model, Scenario, simulate

FACE = '<collision name="leaf">\n      <origin xyz="0.6 -0.02 0.8"'


def write_proud(path: Path, offset: float) -> Path:
    """Write the shipped door with a leaf that stands so far before its hinge's axis [m]."""
    return write_edited(path, DOOR, (FACE, FACE.replace("-0.02", str(offset - 0.02))))


def flown(source: str, duration: float | None = None, seed: int = 0, **overrides: Any) -> dict[str, Any]:
    model = Model(Scenario.load(source, {key.replace("__", "."): value for key, value in overrides.items()}))
    summary = simulate(model, duration, seed=seed).summary
    assert summary is not None
    assert summary["opened"] and summary["collisions"] == 0, summary
    assert abs(summary["final_door_angle_deg"] - math.degrees(model.goal_angle)) < 1.0
    assert summary["min_clearance_m"] > 0.0 and summary["max_constraint_violation_m"] <= 0.01
    assert summary["door_angle_estimate_error_deg_max"] < 0.5
    return dict(summary)


@pytest.mark.slow
def test_a_door_on_the_left_elsewhere_with_a_face_before_the_axis_is_pushed_open(tmp_path: Path) -> None:
    left = write_mirrored(tmp_path / "left.urdf", write_proud(tmp_path / "proud.urdf", 0.04))
    moved = write_moved(tmp_path / "moved.urdf", left, (2.0, -3.0, 0.0), 2.2)
    summary = flown("push", door__urdf=str(moved))
    assert summary["outcome"] == "completed" and summary["contact_fraction"] >= 0.97
    assert summary["max_push_force_n"] < 8.0


@pytest.mark.slow
def test_a_door_on_the_left_is_gripped_open() -> None:
    flown("paper", 12.0, door__urdf="hinged_door_left", goal__attitude=[0.0, 0.0, 1.2217], mission__start="contact")


@pytest.mark.parametrize("source", ["pull", pytest.param("gate", marks=pytest.mark.slow)])
def test_a_leaf_is_moved_by_a_vehicle_that_starts_with_the_grip_on_it(source: str) -> None:
    """No hover has measured thrust and attitude loop before."""
    flown(source, mission__start="contact")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mirrored", "face", "lower", "upper", "opening"),
    [(True, 0.0, -1.5, 1.7, 1.2217), (False, 0.05, -1.5, 1.7, 1.2217), (False, 0.0, 1.45, 3.1, 0.2618)],
    ids=["left", "proud", "pulled"],
)
def test_a_joint_that_goes_on_past_closed(
    mirrored: bool, face: float, lower: float, upper: float, opening: float, tmp_path: Path
) -> None:
    """The tug moves the leaf out of its frame, and says nothing of where the door stands."""
    text = '<limit lower="-1.5" upper="1.5708"'
    door = write_proud(tmp_path / "proud.urdf", face)
    write_edited(door, door, (text, f'<limit lower="{lower}" upper="{upper}"'))
    if mirrored:
        door = write_mirrored(tmp_path / "left.urdf", door)
    keys = {"door.urdf": str(door), "door.closed": 0.5 * math.pi, "goal.opening": opening}
    side = {"contact.side": "pull" if lower > 0.0 else "push", "start.door_angle": None, "goal.door_angle": None}
    summary = simulate(Scenario.load("paper", keys | side)).summary
    assert summary is not None and summary["outcome"] == "completed" and summary["collisions"] == 0, summary
    assert abs(summary["final_error"]) < 0.5


def flown_towards(source: str, seed: int, **overrides: Any) -> None:
    """A door that comes towards the vehicle, or is shut, from hover to hover."""
    scenario = Scenario.load(f"shipped:{source}", {key.replace("__", "."): value for key, value in overrides.items()})
    summary = simulate(scenario, seed=seed).summary
    assert summary is not None and summary["outcome"] == "completed", summary
    assert abs(summary["final_error"]) < 1.5 and summary["unit"] == "deg"
    assert summary["collisions"] == 0 and summary["max_constraint_violation_m"] <= 0.01
    assert summary["min_clearance_m"] > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("source", ["pull", "close", "cabinet", "gate"])
def test_the_shipped_pull_and_close(source: str, seed: int) -> None:
    flown_towards(source, seed)


@pytest.mark.slow
@pytest.mark.parametrize("source", ["pull", "close"])
@pytest.mark.parametrize(("friction", "mass"), [(0.3, 14.4), (0.7, 33.6)])
def test_friction_and_mass_of_a_pulled_door_are_not_known(source: str, friction: float, mass: float) -> None:
    flown_towards(source, 3, simulation__door_friction=friction, simulation__door_mass=mass)


@pytest.mark.slow
@pytest.mark.parametrize("start", [1.2, 0.95])
def test_a_door_is_shut_from_the_side_that_pushes_it_open(start: float) -> None:
    flown_towards("paper", 0, start__door_angle=start, goal__door_angle=1.5707)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_the_shipped_left_door_is_pushed_open(seed: int) -> None:
    summary = flown("push_left", seed=seed)
    assert summary["outcome"] == "completed" and summary["contact_fraction"] >= 0.97


@pytest.mark.slow
@pytest.mark.parametrize("offset", [-0.03, 0.03, 0.06])
@pytest.mark.parametrize("kind", ["paper", "push"])
def test_a_face_beside_the_axis(kind: str, offset: float, tmp_path: Path) -> None:
    flown(kind, door__urdf=str(write_proud(tmp_path / "proud.urdf", offset)))


def pushed_by_the_small_vehicle(**overrides: Any) -> None:
    """A door that the small vehicle does not know."""
    scenario = Scenario.load("push_small", {key.replace("__", "."): value for key, value in overrides.items()})
    summary = simulate(scenario).summary
    assert summary is not None and summary["opened"] and summary["collisions"] == 0, summary
    assert abs(summary["final_error"]) < 2.0 and summary["contact_fraction"] >= 0.97
    assert summary["min_clearance_m"] > 0.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("width", "mass", "friction"), [(0.76, 15.0, 0.5), (0.76, 30.0, 0.3), (0.81, 10.0, 1.0), (0.91, 35.0, 0.8)]
)
def test_a_small_vehicle_pushes_room_doors_open(width: float, mass: float, friction: float) -> None:
    pushed_by_the_small_vehicle(
        door__width=width, simulation__door_mass=mass, simulation__door_friction=friction, simulation__door_damping=0.7
    )


def level(source: str, **overrides: Any) -> dict[str, Any]:
    """A door that a fully actuated vehicle opens; its body stays within 3° of level all the way."""
    recording = simulate(Scenario.load(source, {key.replace("__", "."): value for key, value in overrides.items()}))
    tilt = np.abs(recording["truth"]["attitude"][:, :2]).max()
    summary = recording.summary
    assert summary is not None and summary["opened"] and summary["collisions"] == 0, summary
    assert abs(summary["final_error"]) < 1.0 and summary["min_clearance_m"] > 0.0
    assert math.degrees(tilt) <= 3.0
    return dict(summary)


@pytest.mark.slow
def test_a_fully_actuated_vehicle_pushes_with_a_level_body() -> None:
    assert level("push_tilted")["contact_fraction"] >= 0.98


@pytest.mark.slow
def test_a_fully_actuated_vehicle_grips_with_a_level_body() -> None:
    level("paper_tilted")
