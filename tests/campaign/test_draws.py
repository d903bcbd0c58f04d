"""What a campaign draws: within its distributions, and the same whatever else is drawn or flown."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.campaign import Campaign
from doorman.campaign.specification import draw
from doorman.exceptions import ScenarioError
from doorman.scenario import CampaignSection, Scenario

VARY = {
    "simulation.door_mass": {"min": 6.0, "max": 20.0},
    "simulation.noise.position": {"mean": 0.001, "std": 0.0001},
    "contact.kind": {"choice": ["grip", "push"]},
}


def section(seed: int = 1, **vary: object) -> CampaignSection:
    return CampaignSection(seed=seed, vary=vary or VARY)


def test_a_draw_depends_on_the_seed_and_the_run_alone():
    first = [draw(section(), run) for run in range(20)]
    assert [draw(section(), run) for run in reversed(range(20))][::-1] == first
    assert all(one.values != draw(section(seed=2), one.run).values for one in first)
    assert len({one.seed for one in first}) == 20
    fewer = section(**{"simulation.door_mass": VARY["simulation.door_mass"]})
    for one in first:
        other = draw(fewer, one.run)
        assert other.seed == one.seed
        assert other.values["simulation.door_mass"] == one.values["simulation.door_mass"]


def test_draws_have_their_distributions():
    draws = [draw(section(), run).values for run in range(4000)]
    mass = np.array([one["simulation.door_mass"] for one in draws])
    assert 6.0 <= mass.min() < 6.1 and 19.9 < mass.max() <= 20.0
    assert mass.mean() == pytest.approx(13.0, abs=0.3) and mass.std() == pytest.approx(14.0 / np.sqrt(12), rel=0.05)
    noise = np.array([one["simulation.noise.position"] for one in draws])
    assert noise.mean() == pytest.approx(0.001, rel=0.01) and noise.std() == pytest.approx(0.0001, rel=0.05)
    assert np.mean([one["contact.kind"] == "grip" for one in draws]) == pytest.approx(0.5, abs=0.04)
    assert abs(np.corrcoef(mass, noise)[0, 1]) < 0.06


def test_a_key_may_be_drawn_as_another_one_is():
    both = section(**{"a.one": {"min": 0.0, "max": 2.0}, "a.other": {"same_as": "a.one"}})
    alone = section(**{"a.one": {"min": 0.0, "max": 2.0}})
    for run in range(20):
        drawn = draw(both, run).values
        assert drawn["a.other"] == drawn["a.one"] == draw(alone, run).values["a.one"]


def test_rounding_stays_inside_the_bounds():
    narrow = section(**{"simulation.door_mass": {"min": 6.00000049, "max": 6.00000051}})
    assert {draw(narrow, run).values["simulation.door_mass"] for run in range(50)} <= {6.00000049, 6.00000051}


def test_flights_are_the_scenario_with_its_draws(campaign):
    flights = campaign.flights()
    assert [flight.draw.run for flight in flights] == list(range(5))
    for flight in flights:
        assert flight.scenario.simulation.door_mass == flight.draw.values["simulation.door_mass"]
        assert flight.scenario.simulation.gust.vehicle == flight.draw.values["simulation.gust.vehicle"]
        assert flight.scenario.contact.kind == "push" and flight.duration == 0.2
    assert list(campaign.flights(2)) == flights[:2]
    assert [flight.draw.values["door.width"] == 0.5 for flight in flights] == [False, True, False, False, False]


@pytest.mark.parametrize(
    ("vary", "field"),
    [
        ("simulation.door_masss = { min = 6.0, max = 20.0 }", "simulation.door_masss"),
        ("simulation.door_mass = { min = -1.0, max = -0.5 }", "simulation.door_mass"),
        ("contact.kind = { choice = ['pull'] }", "contact.kind"),
        ("", "campaign.vary"),
    ],
)
def test_what_cannot_be_drawn_is_an_error_before_any_flight(tmp_path, vary, field):
    path = tmp_path / "task.toml"
    path.write_text(f"[campaign.vary]\n{vary}\n")
    with pytest.raises(ScenarioError) as caught:
        Campaign(str(path)).flights(3)
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("vary", "field", "allowed"),
    [
        ("a.b = { min = 1.0 }", "campaign.vary.a.b", "min and max, or choice, or mean and std"),
        ("a.b = { min = 2.0, max = 1.0 }", "campaign.vary.a.b", "min up to max"),
        ("a.b = { min = 1.0, max = 2.0, mean = 1.0 }", "campaign.vary.a.b", "min and max, or choice, or mean and std"),
        ("a.b = { mni = 1.0, max = 2.0 }", "campaign.vary.a.b.mni", "min, max, choice, mean, std"),
        ("a.b = { mean = 1.0, std = -1.0 }", "campaign.vary.a.b.std", "greater than or equal to 0"),
        ("a.b = 3.0", "campaign.vary.a", "min, max"),
        ('a.b = { same_as = "c.d" }', "campaign.vary", "same_as one of none"),
        ('a.b = { same_as = "a.b" }', "campaign.vary", "same_as one of none"),
        ('a.b = { same_as = "a.c", min = 1.0 }', "campaign.vary.a.b", "or same_as"),
    ],
)
def test_a_wrong_distribution_is_an_error_of_the_file(tmp_path, vary, field, allowed):
    path = tmp_path / "task.toml"
    path.write_text(f"[campaign.vary]\n{vary}\n")
    with pytest.raises(ScenarioError) as caught:
        Scenario.load(path)
    assert caught.value.field.startswith(field)
    assert allowed in caught.value.allowed


def test_keys_may_be_quoted_or_nested(tmp_path):
    texts = ('"simulation.door_mass" = { min = 6.0, max = 20.0 }', "simulation.door_mass = { min = 6.0, max = 20.0 }")
    scenarios = []
    for k, text in enumerate(texts):
        (tmp_path / f"{k}.toml").write_text(f"[campaign.vary]\n{text}\n")
        scenarios.append(Scenario.load(tmp_path / f"{k}.toml"))
    assert scenarios[0].campaign == scenarios[1].campaign
    assert list(scenarios[0].campaign.vary) == ["simulation.door_mass"]


def test_the_shipped_campaign_draws_doors_that_can_be_flown():
    flights = Campaign("push_campaign").flights()
    assert len(flights) == 200
    keys = "simulation.door_friction", "simulation.door_width"
    drawn = np.array([[flight.draw.values[key] for key in keys] for flight in flights])
    assert drawn.min(axis=0) == pytest.approx([0.3, 1.1], abs=0.03)
    assert drawn.max(axis=0) == pytest.approx([2.0, 1.4], abs=0.03)
    doors = [flight.scenario.door for flight in flights]
    told = {(door.mass, door.width, door.damping, door.stiffness) for door in doors}
    assert told == {(16.0, 1.1, None, 0.0)}, "the same of every door"
