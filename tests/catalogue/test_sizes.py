"""The shipped missions with every length times a size and every mass times its cube open the door as they are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from completed_flights import completed
from urdf_variants import DOOR, VEHICLE, write_scaled

from doorman.scenario import Scenario


def of_another_size(folder: Path, task: str, size: float) -> Scenario:
    """A shipped mission: its lengths, its door, and the torques of its hinge that it names, in proportion."""
    plain = Scenario.load(f"shipped:{task}")
    true, contact = plain.simulation, plain.contact
    assert true.door_friction is not None and true.door_damping is not None
    keys: dict[str, Any] = {
        "vehicle.urdf": str(write_scaled(folder / "vehicle.urdf", VEHICLE, size)),
        "door.urdf": str(write_scaled(folder / "door.urdf", DOOR, size)),
        "contact.distance_from_hinge": contact.distance_from_hinge * size, "contact.height": contact.height * size,
        "simulation.door_friction": true.door_friction * size**4,
        "simulation.door_damping": true.door_damping * size**4.5,
    }  # fmt: skip
    if "margin" in plain.planner.model_fields_set:
        keys["planner.margin"] = plain.planner.margin * size
    return Scenario.load(f"shipped:{task}", keys)


@pytest.mark.slow
@pytest.mark.parametrize("task", ["paper", "push"])
@pytest.mark.parametrize("size", [0.5, 0.75, 1.5])
def test_a_mission_of_another_size_opens_its_door(task: str, size: float, tmp_path: Path) -> None:
    summary, _ = completed(of_another_size(tmp_path, task, size))
    assert summary["contact_fraction"] > 0.95
