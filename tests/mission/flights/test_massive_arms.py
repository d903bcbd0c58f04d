"""Whole missions with arms that weigh 0.3 and 0.6 kg: the door ends as with the paper's massless arm, and nothing is touched."""

from __future__ import annotations

from pathlib import Path

import pytest
from urdf_variants import write_massive

from doorman import Scenario, simulate
from doorman.feasibility import Severity
from doorman.feasibility.lift import lift_findings
from doorman.model import Model

SHARES = {"servo_1": 0.22, "servo_2": 0.23, "servo_3": 0.28, "servo_4": 0.27}
"""Of the arm's mass: servos and frames."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("task", "mass", "seed"),
    [("paper", 0.3, 0), ("paper", 0.6, 1), ("push", 0.6, 0)],
)
def test_the_door_ends_as_without_the_mass(tmp_path: Path, task: str, mass: float, seed: int) -> None:
    urdf = write_massive(tmp_path / "arm.urdf", {link: mass * share for link, share in SHARES.items()})
    summary = simulate(Scenario.load(task, {"vehicle.urdf": str(urdf)}), seed=seed).summary
    assert summary is not None and summary["opened"] and summary["outcome"] == "completed"
    assert abs(summary["final_door_angle_deg"] - 20.0) < 1.0
    assert summary["collisions"] == 0 and summary["min_clearance_m"] > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("task", ["paper", "push"])
def test_the_shipped_vehicle_with_its_servos_masses(task: str) -> None:
    summary = simulate(Scenario.load(task, {"vehicle.urdf": "hexarotor_arm_with_mass"}), seed=0).summary
    assert summary is not None and summary["opened"] and summary["collisions"] == 0
    assert abs(summary["final_door_angle_deg"] - 20.0) < 1.0


def test_an_arm_that_the_rotors_do_not_hold_is_refused(tmp_path: Path) -> None:
    """0.9 kg at the arm's end: level, the rotors lift less than the weight, whether the tip grips or pushes."""
    urdf = write_massive(tmp_path / "arm.urdf", {"servo_4": 0.9}, center=(0.15, 0.0, 0.0))
    arm, level = (0.0, 1.0, -0.6, -0.4), (0.0, 0.0, 0.0)
    pinned = {
        "start.arm": arm,
        "goal.arm": arm,
        "start.attitude": level,
        "goal.attitude": level,
        "vehicle.urdf": str(urdf),
    }
    for task in ("paper", "push"):
        model = Model(Scenario.load(task, pinned))
        (finding,) = [each for each in lift_findings(model) if each.name == "centre of mass"]
        assert finding.severity is Severity.ERROR and "lift" in finding.message
