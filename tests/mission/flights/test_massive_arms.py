"""Whole missions with arms that have mass: the door ends as with the paper's massless arm, and nothing is touched."""

from __future__ import annotations

from pathlib import Path

import pytest
from completed_flights import completed
from urdf_variants import write_massive

from doorman import Scenario
from doorman.feasibility import Severity
from doorman.feasibility.lift import lift_findings
from doorman.model import Model

SHARES = {"servo_1": 0.22, "servo_2": 0.23, "servo_3": 0.28, "servo_4": 0.27}
"""Of the arm's mass: servos and frames."""
SHIPPED = "hexarotor_arm_with_mass"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("task", "mass", "seed"),
    [("paper", 0.3, 0), ("paper", 0.6, 1), ("push", 0.6, 0), ("paper", None, 0), ("push", None, 0)],
)
def test_the_door_ends_as_without_the_mass(tmp_path: Path, task: str, mass: float | None, seed: int) -> None:
    """Of arms of so many kilograms, or the shipped one."""
    urdf = SHIPPED
    if mass is not None:
        links = {link: mass * share for link, share in SHARES.items()}
        urdf = str(write_massive(tmp_path / "arm.urdf", links))
    summary, _ = completed(task, {"vehicle.urdf": urdf}, seed, final_error=1.0)
    assert summary["min_clearance_m"] > 0.0


def test_an_arm_that_the_rotors_do_not_hold_is_refused(tmp_path: Path) -> None:
    """0.9 kg at the arm's end: level, the rotors lift less than the weight, whether the tip grips or pushes."""
    urdf = write_massive(tmp_path / "arm.urdf", {"servo_4": 0.9}, center=(0.15, 0.0, 0.0))
    pinned = {f"{end}.arm": (0.0, 1.0, -0.6, -0.4) for end in ("start", "goal")}
    pinned |= {f"{end}.attitude": (0.0, 0.0, 0.0) for end in ("start", "goal")}
    for task in ("paper", "push"):
        model = Model(Scenario.load(task, {"vehicle.urdf": str(urdf), **pinned}))
        (finding,) = [each for each in lift_findings(model) if each.name == "centre of mass"]
        assert finding.severity is Severity.ERROR and "lift" in finding.message
