"""Defaults that grow with the vehicle, and what a scenario gives itself."""

from __future__ import annotations

from pathlib import Path

import pytest
from urdf_variants import VEHICLE, write_scaled

from doorman.campaign.specification import portable
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.scenario.sized import sized
from doorman.scenario.sized_keys import SIZED


def value(scenario: Scenario, key: str) -> float:
    found = scenario
    for name in key.split("."):
        found = getattr(found, name)
    return found  # type: ignore[return-value]


@pytest.mark.parametrize("size", [0.5, 1.5])
def test_defaults_are_shares_of_the_vehicle_s_weight_and_length(tmp_path: Path, size: float) -> None:
    vehicle = write_scaled(tmp_path / "vehicle.urdf", VEHICLE, size)
    larger = Model(Scenario.load("paper", {"vehicle.urdf": str(vehicle)})).scenario
    usual = Scenario.load("paper")
    for key, unit in SIZED.items():
        assert value(larger, key) == pytest.approx(value(usual, key) * size ** (3 if unit == "force" else 4)), key


def test_the_shipped_vehicle_has_them_as_they_are() -> None:
    scenario = Scenario.load("push")
    assert Model(scenario).scenario is scenario


def test_what_is_given_stays_and_is_not_grown_again() -> None:
    given = Scenario.load("paper", {"control.max_push": 7.0, "estimation.contact.touched_above": 0.4})
    once = sized(given, {"force": 2.0, "torque": 3.0})
    assert (once.control.max_push, once.estimation.contact.touched_above) == (7.0, 0.4)
    assert (once.control.max_disturbance, once.control.max_door_disturbance) == (20.0, 15.0)
    assert once.source == given.source
    again = sized(once, {"force": 2.0, "torque": 3.0})
    assert again == once


def test_a_default_stays_one_when_a_scenario_is_saved_copied_or_changed(tmp_path: Path) -> None:
    scenario = Scenario.load("push_small", {"mission.touch_force": 0.4})
    copies = (
        Scenario.load(scenario.save(tmp_path / "saved.toml")), scenario.replace(contact__height=0.8),
        scenario.model_copy(update={"control": scenario.control.model_copy(update={"max_tilt": 0.3})}),
        Scenario(**portable(scenario)),
    )  # fmt: skip
    wanted = Model(scenario).scenario
    for copy in copies:
        found = Model(copy).scenario
        assert [value(found, key) for key in SIZED] == [value(wanted, key) for key in SIZED]
        assert found.mission.touch_force == 0.4
