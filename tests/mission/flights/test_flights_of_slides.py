"""Drawers, slides, hatches and leaning doors, gripped and pushed, flown from hover to hover."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from urdf_variants import DOOR, write_edited

from doorman import Scenario, simulate
from doorman.resources import urdf_directory

HANDLES = urdf_directory() / "door_with_handle.urdf"


def flown(source: str, seed: int, **overrides: Any) -> dict[str, Any]:
    """Within a centimetre, and nothing touched."""
    scenario = Scenario.load(f"shipped:{source}", {key.replace("__", "."): value for key, value in overrides.items()})
    summary = simulate(scenario, seed=seed).summary
    assert summary is not None and summary["outcome"] == "completed", summary
    assert abs(summary["final_error"]) < {"m": 0.01, "deg": 1.5}[summary["unit"]]
    assert summary["collisions"] == 0 and summary["min_clearance_m"] > 0.0
    assert summary["max_constraint_violation_m"] <= 0.01
    return dict(summary)


def test_a_drawer_is_pulled_open() -> None:
    summary = flown("drawer", 1)
    assert summary["unit"] == "m"
    assert summary["final_opening"] == pytest.approx(0.3, abs=0.01) and summary["target_opening"] == pytest.approx(0.3)
    found = summary["estimates"]
    for name, true in (("friction", 2.0), ("damping", 5.0), ("inertia", 6.0)):
        assert found[name]["true"] == pytest.approx(true)
        assert abs(found[name]["value"] - true) < 2.0 * found[name]["deviation"]


@pytest.mark.slow
def test_a_gate_is_slid_open() -> None:
    assert flown("sliding", 1)["target_opening"] == pytest.approx(0.6)


@pytest.mark.slow
def test_a_hatch_is_lifted() -> None:
    assert flown("hatch", 1)["unit"] == "deg"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("source", ["drawer", "sliding", "hatch"])
def test_the_shipped_slides(source: str, seed: int) -> None:
    flown(source, seed)


@pytest.mark.slow
@pytest.mark.parametrize("source", ["drawer", "sliding"])
def test_a_slide_is_shut(source: str) -> None:
    summary = flown(source, 2, start__opening=0.3, goal__opening=0.02)
    assert summary["target_opening"] == pytest.approx(0.02)


@pytest.mark.slow
@pytest.mark.parametrize(("friction", "mass"), [(1.2, 3.6), (2.8, 8.4)])
def test_friction_and_mass_of_a_drawer_are_not_known(friction: float, mass: float) -> None:
    flown("drawer", 3, simulation__door_friction=friction, simulation__door_mass=mass)


@pytest.mark.slow
@pytest.mark.parametrize("lean", [0.001, 0.0175, 0.03])
def test_a_leaning_door_is_pulled_open(lean: float, tmp_path: Path) -> None:
    """Its weight shuts it, and the estimators know by how much."""
    plumb = '<origin xyz="0 0 0.01" rpy="0 0 1.5707963267948966"/>'
    urdf = write_edited(tmp_path / "door.urdf", HANDLES, (plumb, plumb.replace("0 0 1.57", f"{-lean} 0 1.57")))
    summary = flown("pull", 0, door__urdf=str(urdf))
    assert summary["door_angle_estimate_error_deg_max"] < 1.0


@pytest.mark.slow
def test_a_drawer_is_pushed_shut() -> None:
    """From where it stands almost shut: the leaf goes away from the vehicle, and its stop is the goal."""
    summary = flown("drawer_close", 1, start__opening=0.1, mission__start="contact")
    assert summary["contact_fraction"] >= 0.97 and summary["max_push_force_n"] < 8.0
    assert summary["final_opening"] == pytest.approx(0.0, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_the_shipped_drawer_is_pushed_shut(seed: int) -> None:
    summary = flown("drawer_close", seed)
    assert summary["contact_fraction"] >= 0.97 and summary["max_push_force_n"] < 8.0


@pytest.mark.slow
@pytest.mark.parametrize(("friction", "mass"), [(1.2, 3.6), (3.0, 8.4)])
def test_a_pushed_drawer_is_not_known(friction: float, mass: float) -> None:
    flown("drawer_close", 2, simulation__door_friction=friction, simulation__door_mass=mass)


@pytest.mark.slow
@pytest.mark.parametrize("friction", [2.6, 3.2])
def test_a_flap_is_pushed_shut(friction: float) -> None:
    """Its hinge holds it against its weight where it stands open; the push begins along a normal that looks down."""
    keys = {
        "contact__kind": "push",
        "contact__frame": None,
        "contact__side": "pull",
        "contact__distance_from_hinge": 0.5,
    }
    summary = flown("hatch", 1, **keys, start__opening=0.5, goal__opening=0.0, simulation__door_friction=friction)
    assert summary["contact_fraction"] >= 0.97


@pytest.mark.slow
@pytest.mark.parametrize("lean", ["0 -0.02 0", "-0.03 0 0"])
def test_a_leaning_door_is_pushed_open(lean: str, tmp_path: Path) -> None:
    """Its weight shuts it, or presses on it only far open."""
    plumb = '<origin xyz="0 0 0.4" rpy="0 0 0"/>\n    <parent'
    urdf = write_edited(tmp_path / "door.urdf", DOOR, (plumb, plumb.replace("0 0 0", lean)))
    summary = flown("push", 0, door__urdf=str(urdf))
    assert summary["contact_fraction"] >= 0.97 and summary["door_angle_estimate_error_deg_max"] < 1.0


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [100, 110])
def test_a_door_is_pushed_open_beyond_a_right_angle(degrees: int) -> None:
    summary = flown("push", 0, goal__opening=math.radians(degrees))
    assert summary["final_opening"] == pytest.approx(degrees, abs=1.5)
    assert summary["door_angle_estimate_error_deg_max"] < 1.0
