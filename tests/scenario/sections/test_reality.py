"""Presets of reality: they set and draw what the scenario leaves open, and what it gives wins, whichever way it is made."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from doorman.campaign import Campaign
from doorman.exceptions import ScenarioError
from doorman.scenario import RealitySection, Scenario, SimulationSection
from doorman.scenario.sections.simulation import GustSection

PRESETS = ("mild", "rough", "hostile")


@pytest.mark.parametrize("preset", PRESETS)
def test_a_preset_sets_and_draws(preset):
    scenario = Scenario.load("push", {"reality.preset": preset})
    vary = scenario.campaign.vary
    assert scenario.simulation.thrust_scale != 1.0 and scenario.simulation.sensors.latency > 0.0
    assert {"simulation.thrust_scale", "simulation.door_offset", "simulation.gust.vehicle"} <= set(vary)
    assert not Scenario.load("push").campaign.vary and Scenario.load("push").simulation.thrust_scale == 1.0


@pytest.mark.parametrize("preset", PRESETS)
def test_every_value_of_a_preset_lies_in_what_it_draws(preset):
    scenario = Scenario(reality=RealitySection(preset=preset)).model_dump()
    for key, drawn in scenario["campaign"]["vary"].items():
        value = scenario
        for part in key.split("."):
            value = value[part]
        if drawn["min"] is not None:
            assert drawn["min"] <= value <= drawn["max"], key


def test_each_preset_is_rougher_than_the_one_before():
    sections = [Scenario.load("push", {"reality.preset": preset}).simulation for preset in PRESETS]
    for figure in (
        lambda one: abs(math.log(one.thrust_scale)), lambda one: math.hypot(*one.door_offset), lambda one: one.door_seal,
        lambda one: one.sensors.latency, lambda one: one.servo_backlash,
        lambda one: -one.gripper_force, lambda one: one.noise.position,
    ):  # fmt: skip
        figures = [figure(one) for one in sections]
        assert figures == sorted(figures) and figures[0] < figures[2]


def test_what_is_given_wins_and_is_not_drawn(tmp_path: Path):
    file = tmp_path / "task.toml"
    file.write_text(
        '[reality]\npreset = "rough"\n[simulation]\nthrust_scale = 1.2\n[simulation.gust]\nvehicle = 0.0\n'
        "[campaign.vary]\nsimulation.door_seal = { min = 1.0, max = 1.5 }\n"
    )
    scenario = Scenario.load(file, {"simulation.sensors.latency": 0.001})
    vary = scenario.campaign.vary
    assert (scenario.simulation.thrust_scale, scenario.simulation.gust.vehicle) == (1.2, 0.0)
    assert scenario.simulation.sensors.latency == 0.001
    assert not {"simulation.thrust_scale", "simulation.gust.vehicle", "simulation.sensors.latency"} & set(vary)
    assert vary["simulation.door_seal"].max == 1.5
    assert scenario.simulation.gust.leaf == 1.0 and "simulation.gust.leaf" in vary


def test_all_ways_to_make_a_scenario_agree(tmp_path: Path):
    loaded = Scenario.load("push", {"reality.preset": "mild", "simulation.door_seal": 2.0})
    assert Scenario.load("push").replace({"reality.preset": "mild", "simulation.door_seal": 2.0}) == loaded
    assert loaded.replace(contact__height=0.9).simulation == loaded.simulation
    assert Scenario.load(loaded.save(tmp_path / "saved.toml")) == loaded
    assert Scenario.model_validate(loaded.portable(mode="json")).campaign == loaded.campaign
    built = Scenario(reality={"preset": "mild"}, simulation=SimulationSection(gust=GustSection(turn_rate=0.3)))
    assert built.simulation.gust.turn_rate == 0.3
    assert built.simulation.gust.vehicle == loaded.simulation.gust.vehicle
    assert "simulation.gust.turn_rate" not in built.campaign.vary


def test_unknown_and_second_presets_are_refused():
    with pytest.raises(ScenarioError, match=r"reality\.preset.*'mild', 'rough' or 'hostile'"):
        Scenario.load("push", {"reality.preset": "gentle"})
    with pytest.raises(ScenarioError, match=r"reality\.preset") as caught:
        Scenario.load("push", {"reality.preset": "mild"}).replace({"reality.preset": "rough"})
    assert "mild" in str(caught.value.allowed)
    with pytest.raises(ScenarioError, match="simulation"):
        Scenario.load("push", {"reality.preset": "mild", "simulation": 3})


@pytest.mark.parametrize("preset", PRESETS)
def test_the_shipped_campaigns_draw_their_preset(preset):
    """Every end of every range can be flown, and single keys can be fixed."""
    campaign = Campaign(f"reality_{preset}", {"simulation.thrust_scale": 1.0})
    flight = campaign.flights(3)[2]
    assert "simulation.thrust_scale" not in flight.draw.values and flight.scenario.simulation.thrust_scale == 1.0
    for key in ("simulation.vehicle_mass", "simulation.door_seal", "simulation.gust.turn_rate"):
        value = flight.draw.values[key]
        part: object = flight.scenario
        for name in key.split("."):
            part = getattr(part, name)
        assert part == value
