"""Doors on the left, elsewhere, leaning, sealed and with a face before the axis; drawers, slides and hatches: flown."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from completed_flights import completed, kept_clear
from urdf_variants import DOOR, write_edited, write_mirrored, write_moved

from doorman.resources import urdf_directory

STRICT = {"final_error": 1.0, "door_angle_estimate_error_deg_max": 0.5}
FACE = '<collision name="leaf">\n      <origin xyz="0.6 -0.02 0.8"'


def write_proud(path: Path, offset: float) -> Path:
    """Write the shipped door with a leaf that stands so far before its hinge's axis [m]."""
    return write_edited(path, DOOR, (FACE, FACE.replace("-0.02", str(offset - 0.02))))


def true(**values: float) -> dict[str, float]:
    """Keys of the true door."""
    return {f"simulation.door_{name}": value for name, value in values.items()}


def test_a_drawer_is_pulled_open() -> None:
    summary = kept_clear("drawer", seed=1)
    assert summary["unit"] == "m"
    assert summary["final_opening"] == pytest.approx(0.3, abs=0.01) and summary["target_opening"] == pytest.approx(0.3)
    found = summary["estimates"]
    for name, value in (("friction", 2.0), ("damping", 5.0), ("inertia", 6.0)):
        assert found[name]["true"] == pytest.approx(value)
        assert abs(found[name]["value"] - value) < 2.0 * found[name]["deviation"]


@pytest.mark.parametrize("source", ["pull", pytest.param("gate", marks=pytest.mark.slow)])
def test_a_leaf_is_moved_by_a_vehicle_that_starts_with_the_grip_on_it(source: str) -> None:
    """No hover has measured thrust and attitude loop before."""
    kept_clear(source, {"mission.start": "contact"}, **STRICT)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize(
    ("source", "most"),
    [
        *((source, {}) for source in ("pull", "close", "cabinet", "gate", "drawer", "sliding", "hatch")),
        ("push_left", STRICT),
        ("drawer_close", {"max_push_force_n": 8.0}),
    ],
)
def test_a_shipped_task(source: str, most: dict[str, float], seed: int) -> None:
    kept_clear(source, seed=seed, **most)


SHUT = {"goal.door_angle": 1.5707}
FLAP = {
    "contact.kind": "push", "contact.frame": None, "contact.side": "pull", "contact.distance_from_hinge": 0.5,
    "start.opening": 0.5, "goal.opening": 0.0,
}  # fmt: skip
"""A hatch that is pushed shut; its hinge holds it against its weight, and the push begins along a normal that looks down."""
ROOMS = [(0.76, 15.0, 0.5), (0.76, 30.0, 0.3), (0.81, 10.0, 1.0), (0.91, 35.0, 0.8)]
"""Width, mass and friction of room doors."""
OTHERS: list[tuple[str, dict[str, Any], int, dict[str, float]]] = [
    ("paper", {"door.urdf": "hinged_door_left", "goal.attitude": [0.0, 0.0, 1.2217]}, 0, STRICT),
    *(("paper", {"start.door_angle": start, **SHUT}, 0, {}) for start in (1.2, 0.95)),
    *((source, true(friction=friction, mass=mass), 3, {})
      for source in ("pull", "close") for friction, mass in ((0.3, 14.4), (0.7, 33.6))),
    *(("push_small", {"door.width": width, **true(mass=mass, friction=friction, damping=0.7)}, 0, {"final_error": 2.0})
      for width, mass, friction in ROOMS),
    *((source, {"start.opening": 0.3, "goal.opening": 0.02}, 2, {}) for source in ("drawer", "sliding")),
    *(("drawer", true(friction=friction, mass=mass), 3, {}) for friction, mass in ((1.2, 3.6), (2.8, 8.4))),
    *(("drawer_close", true(friction=friction, mass=mass), 2, {}) for friction, mass in ((1.2, 3.6), (3.0, 8.4))),
    ("drawer_close", {"start.opening": 0.1, "mission.start": "contact"}, 1, {"max_push_force_n": 8.0}),
    *(("hatch", FLAP | true(friction=friction), 1, {}) for friction in (2.6, 3.2)),
    *(("push", {"goal.opening": math.radians(degrees)}, 0, {"door_angle_estimate_error_deg_max": 1.0})
      for degrees in (100, 110)),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("source", "keys", "seed", "most"), OTHERS)
def test_another_task(source: str, keys: dict[str, Any], seed: int, most: dict[str, float]) -> None:
    """Doors that are shut, that stand beyond a right angle, or whose mass and friction nobody knows."""
    kept_clear(source, keys, seed, **most)


# ---------------------------------------------------------------- faces and hinges


@pytest.mark.slow
def test_a_door_on_the_left_elsewhere_with_a_face_before_the_axis_is_pushed_open(tmp_path: Path) -> None:
    left = write_mirrored(tmp_path / "left.urdf", write_proud(tmp_path / "proud.urdf", 0.04))
    moved = write_moved(tmp_path / "moved.urdf", left, (2.0, -3.0, 0.0), 2.2)
    kept_clear("push", {"door.urdf": str(moved)}, **STRICT, max_push_force_n=8.0)


@pytest.mark.slow
@pytest.mark.parametrize("offset", [-0.03, 0.03, 0.06])
@pytest.mark.parametrize("source", ["paper", "push"])
def test_a_face_beside_the_axis(source: str, offset: float, tmp_path: Path) -> None:
    kept_clear(source, {"door.urdf": str(write_proud(tmp_path / "proud.urdf", offset))}, **STRICT)


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
    completed("paper", keys | side, final_error=0.5)


PLUMB = {
    "pull": (urdf_directory() / "door_with_handle.urdf", '<origin xyz="0 0 0.01" rpy="0 0 1.5707963267948966"/>', "0 0 1.57"),
    "push": (DOOR, '<origin xyz="0 0 0.4" rpy="0 0 0"/>\n    <parent', "0 0 0"),
}  # fmt: skip
"""Doors whose hinge is upright, the place of it, and its attitude there."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("source", "leans"),
    [*(("pull", f"{-lean} 0 1.57") for lean in (0.001, 0.0175, 0.03)), ("push", "0 -0.02 0"), ("push", "-0.03 0 0")],
)
def test_a_leaning_door(source: str, leans: str, tmp_path: Path) -> None:
    """Its weight shuts it, or presses on it only far open; the estimators know by how much."""
    urdf, place, upright = PLUMB[source]
    leaning = write_edited(tmp_path / "door.urdf", urdf, (place, place.replace(upright, leans)))
    kept_clear(source, {"door.urdf": str(leaning)}, door_angle_estimate_error_deg_max=1.0)


# ---------------------------------------------------------------- seals and latches

SEALED = true(seal=4.0)
LIGHT, STUBBORN = true(mass=8.0, friction=0.3, damping=0.0), true(friction=1.0, damping=1.0)
DRAUGHT = {"simulation.gust.vehicle": 1.0, "simulation.gust.leaf": 1.0}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("source", "keys", "seed"),
    [
        *(("push", SEALED | keys, 2) for keys in (LIGHT, STUBBORN, true(stiffness=1.0) | DRAUGHT)),
        ("push_left", true(latch=4.0), 6),
    ],
)
def test_a_door_that_a_seal_or_a_latch_holds_is_pushed_open_and_not_flung(
    source: str, keys: dict[str, float], seed: int
) -> None:
    completed(source, keys, seed, final_error=2.0, max_push_force_n=12.5)


@pytest.mark.slow
@pytest.mark.parametrize("keys", [{}, true(mass=7.0)])
def test_a_sealed_door_is_gripped_open_and_the_seal_is_no_friction(keys: dict[str, float]) -> None:
    summary, _ = completed("paper", SEALED | keys, 1, final_error=1.0, max_push_force_n=12.5)
    assert summary["estimates"]["torque"]["value"] < 1.0


# ---------------------------------------------------------------- level bodies and side wind


@pytest.mark.slow
@pytest.mark.parametrize("source", ["push_tilted", "paper_tilted"])
def test_a_fully_actuated_vehicle_keeps_its_body_level(source: str) -> None:
    summary, recording = completed(source, final_error=1.0)
    assert summary["min_clearance_m"] > 0.0 and summary["contact_fraction"] >= 0.98
    assert math.degrees(np.abs(recording["truth"]["attitude"][:, :2]).max()) <= 3.0


@pytest.mark.parametrize(
    "direction", [math.pi / 2, pytest.param(-math.pi / 2, marks=pytest.mark.slow)], ids=["against", "along"]
)
def test_a_grip_opens_the_door_in_side_wind_at_the_first_attempt(direction: float) -> None:
    """It comes to blow along the leaf's normal as the door opens."""
    wind = {"vehicle": 2.0, "variation": 0.0, "direction": direction}
    keys = {f"simulation.gust.{name}": value for name, value in wind.items()}
    summary, recording = completed("paper", keys, final_error=1.0)
    assert summary["contact_fraction"] >= 0.98 and list(recording["mission"]["state"]).count("open") == 1
