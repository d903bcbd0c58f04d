"""The flying arms of example-robot-data, by their own URDFs and meshes: one opens the paper's door, one cannot reach it."""

from __future__ import annotations

import pytest
from completed_flights import completed
from urdf_variants import robot_data_vehicle

from doorman.feasibility.swing.geometry import geometry_findings
from doorman.model import Model
from doorman.scenario import Scenario

STEEPER = {"control.max_tilt": 0.35, "vehicle.rotors.assume": True}
"""The door's force is a larger share of the weight than the shipped vehicle's. The URDFs have no rotors."""


def task_of(name: str) -> Scenario:
    """The paper's task for a vehicle of example-robot-data."""
    _, names = robot_data_vehicle(name)
    given = {f"vehicle.{key}": value for key, value in names.model_dump(exclude_unset=True).items()}
    return Scenario.load("shipped:paper", {**given, **STEEPER})


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_borinot_opens_the_door_of_the_paper(seed: int) -> None:
    summary, _ = completed(task_of("borinot_flying_arm_2"), seed=seed)
    assert summary["contact_fraction"] > 0.95


@pytest.mark.slow
def test_an_arm_that_ends_within_its_rotors_disc_is_refused() -> None:
    """Hextilt's arm is 0.30 m long, its disc 0.43 m: no upright leaf is within reach."""
    found = {one.name for one in geometry_findings(Model(task_of("hextilt_flying_arm_5"))) if not one.ok}
    assert "reach" in found
