"""Defaults that grow with the vehicle, and what a scenario gives itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from urdf_variants import DOOR, VEHICLE, write_scaled

from doorman.model import Model
from doorman.scenario import Scenario
from doorman.scenario.sized import sized
from doorman.scenario.sized_keys import SIZED

POWERS = {
    "force": 3.0, "torque": 4.0, "length": 1.0, "speed": 0.5, "rate": -0.5, "stiffness": 2.0, "resistance": 4.0, "hinge": 4.0
}  # fmt: skip
"""Of the size, by unit, where the door is of that size as well."""


def value(scenario: Scenario, key: str) -> float:
    found = scenario
    for name in key.split("."):
        found = getattr(found, name)
    return found  # type: ignore[return-value]


def of_size(folder: Path, vehicle: float, door: float) -> Model:
    """The paper's task with vehicle and door of other sizes."""
    keys = {
        "vehicle.urdf": str(write_scaled(folder / "vehicle.urdf", VEHICLE, vehicle)),
        "door.urdf": str(write_scaled(folder / "door.urdf", DOOR, door)),
        "contact.distance_from_hinge": 0.7 * door, "contact.height": 0.8 * door,
    }  # fmt: skip
    return Model(Scenario.load("paper", keys))


@pytest.mark.parametrize("size", [0.5, 1.5])
def test_defaults_are_shares_of_the_vehicle_s_weight_and_length(tmp_path: Path, size: float) -> None:
    other, usual = of_size(tmp_path, size, size).scenario, Scenario.load("paper")
    for key, unit in SIZED.items():
        assert value(other, key) == pytest.approx(np.multiply(value(usual, key), size ** POWERS[unit])), key


@pytest.mark.parametrize(("vehicle", "door"), [(0.6, 1.0), (1.0, 0.6), (1.5, 1.0), (1.0, 1.2)])
def test_a_hinge_is_a_room_door_s_unless_both_are_smaller_or_larger(
    tmp_path: Path, vehicle: float, door: float
) -> None:
    other = of_size(tmp_path, vehicle, door)
    assert other.hinge_scale == pytest.approx(1.0)


def test_the_shipped_vehicle_has_them_as_they_are() -> None:
    scenario = Scenario.load("push")
    assert Model(scenario).scenario is scenario


def test_what_is_given_stays_and_is_not_grown_again() -> None:
    given = Scenario.load("paper", {"control.max_push": 7.0, "planner.margin": 0.05})
    ratios = dict.fromkeys(POWERS, 1.0) | {"force": 2.0, "torque": 3.0, "length": 4.0}
    once = sized(given, ratios)
    assert (once.control.max_push, once.planner.margin) == (7.0, 0.05)
    assert once.control.max_door_disturbance == 15.0
    assert once.source == given.source
    again = sized(once, ratios)
    assert again == once


def test_a_default_stays_one_when_a_scenario_is_saved_copied_or_changed(tmp_path: Path) -> None:
    scenario = Scenario.load("push_small", {"control.max_push": 4.0})
    copies = (
        Scenario.load(scenario.save(tmp_path / "saved.toml")), scenario.replace(contact__height=0.8),
        scenario.model_copy(update={"control": scenario.control.model_copy(update={"max_tilt": 0.3})}),
        Scenario(**scenario.portable(mode="json")),
    )  # fmt: skip
    wanted = Model(scenario).scenario
    for copy in copies:
        found = Model(copy).scenario
        assert [value(found, key) for key in SIZED] == [value(wanted, key) for key in SIZED]
        assert found.control.max_push == 4.0
