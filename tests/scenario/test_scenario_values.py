"""Scenarios made and changed in Python: numpy's numbers, errors of ours, replace, save, equality and hashes."""

from __future__ import annotations

import math
import pickle
from fractions import Fraction
from functools import lru_cache
from pathlib import Path, PurePosixPath
from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from urdf_variants import write_door

from doorman.exceptions import DoormanError, ScenarioError
from doorman.model import Model
from doorman.planning.planner import Planner
from doorman.scenario import ContactSection, PlannerSection, Scenario, WeightsSection

# ---------------------------------------------------------------- what Python has beside TOML's values


@pytest.mark.parametrize(
    ("key", "value", "read"),
    [
        ("planner.horizon_steps", np.uint8(30), 30),
        ("planner.horizon_steps", np.array(30), 30),
        ("planner.margin", np.float32(0.25), 0.25),
        ("planner.margin", np.longdouble(0.25), 0.25),
        ("planner.margin", np.int16(0), 0.0),
        ("planner.margin", Fraction(1, 4), 0.25),
        ("limits.enabled", np.bool_(False), False),
        ("contact.kind", np.str_("push"), "push"),
        ("door.urdf", PurePosixPath("/a/door.urdf"), "/a/door.urdf"),
        ("start.arm", np.array([0, 1, 2, 3]), (0.0, 1.0, 2.0, 3.0)),
        ("start.arm", [np.float32(0.5), np.int8(1), 2, 0.25], (0.5, 1.0, 2.0, 0.25)),
        ("planner.weights", MappingProxyType({"state": np.ones(9)}), WeightsSection(state=(1.0,) * 9)),
    ],
)
def test_numbers_arrays_and_paths_are_values(key, value, read):
    section, field = key.split(".")
    for scenario in (
        Scenario.load("paper", {key: value}),
        Scenario(**{section: {field: value}}),
        Scenario().replace({key: value}),
        Scenario().replace(**{section: {field: value}}),
        Scenario().replace(**{f"{section}__{field}": value}),
        Scenario().replace(**{section: getattr(Scenario(), section).model_copy(update={field: value})}),
    ):
        given = getattr(getattr(scenario, section), field)
        assert given == read and type(given) is type(read)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("planner.margin", np.bool_(True)),
        ("planner.margin", 0.1 + 0.0j),
        ("planner.margin", np.float32(np.nan)),
        ("planner.margin", Path("0.1")),
        ("planner.margin", np.datetime64("2020-01-01")),
        ("planner.horizon_steps", np.float64(30.0)),
        ("limits.enabled", np.int64(1)),
        ("contact.kind", np.str_("pull")),
        ("start.arm", np.zeros((2, 2))),
        ("start.arm", [0.0, True, 0.0, 0.0]),
    ],
)
def test_what_is_no_such_value_names_its_field(key, value):
    section, field = key.split(".")
    for make in (
        lambda: Scenario.load("paper", {key: value}),
        lambda: Scenario(**{section: {field: value}}),
        lambda: Scenario().replace({key: value}),
        lambda: Scenario().model_copy(update={section: {field: value}}),
    ):
        with pytest.raises(ScenarioError) as caught:
            make()
        assert caught.value.field.startswith(key)
        assert caught.value.given is not None and caught.value.allowed
    with pytest.raises(ScenarioError) as caught:
        type(getattr(Scenario(), section))(**{field: value})
    assert caught.value.field.startswith(field)


def test_a_constructor_says_what_it_takes():
    for make, word in (
        (lambda: Scenario(planer={}), "planner"),
        (lambda: Scenario(planner={"margn": 0.1}), "margin"),
        (lambda: Scenario(planner=ContactSection()), "planner"),
        (lambda: Scenario("paper"), "Scenario.load"),
        (lambda: PlannerSection(0.1), "margin"),
        (lambda: Scenario(campaign={"vary": {"a.b": {"min": 1.0, "max": 0.0}}}), "min up to max"),
    ):
        with pytest.raises(DoormanError, match=word):
            make()


# ---------------------------------------------------------------- sources


def test_a_name_or_a_path_stands_for_a_scenario(tmp_path):
    (tmp_path / "task.toml").write_text("[contact]\nheight = 0.6\n")
    assert Model("push").scenario == Scenario.load("push")
    for source in (tmp_path / "task.toml", str(tmp_path / "task.toml")):
        assert Model(source).scenario.contact.height == 0.6
    planner = Planner("paper")
    assert planner.plan(planner.model.start_state).usable


@pytest.mark.parametrize("source", [3, None, b"paper", ["paper"], {"contact": {}}, np.str_("no such")])
def test_what_is_no_scenario_is_an_error_of_ours(source):
    for make in (Scenario.load, Model, Planner):
        with pytest.raises(ScenarioError) as caught:
            make(source)
        assert "paper" in str(caught.value) or "a name" in str(caught.value)


@pytest.mark.parametrize("overrides", [["planner.margin"], "planner.margin=1", {3: 1}, {"planner": {3: 1}}])
def test_what_are_no_overrides_is_an_error_of_ours(overrides):
    with pytest.raises(ScenarioError):
        Scenario.load("paper", overrides)
    with pytest.raises(ScenarioError):
        Scenario().replace(overrides)


# ---------------------------------------------------------------- replace and copies


def test_replace_changes_what_it_names_alone():
    scenario = Scenario.load("push", {"contact.height": 0.7, "planner.weights.input": [1.0] * 8})
    other = scenario.replace({"planner.weights.state": [2.0] * 9}, contact={"distance_from_hinge": 0.5})
    assert other.contact == ContactSection(height=0.7, distance_from_hinge=0.5, kind="push")
    assert other.planner.weights == WeightsSection(state=(2.0,) * 9, input=(1.0,) * 8)
    assert other.control == scenario.control and (other.source, other.name) == (scenario.source, "push")
    assert other.replace(contact=scenario.contact, planner__weights__state=None) == scenario
    assert scenario.contact.height == 0.7 and scenario.planner.weights.state is None


def test_replace_takes_what_is_drawn_as_one_value():
    scenario = Scenario.load("push_campaign").replace({"campaign.vary": {"contact.height": {"min": 0.5, "max": 0.9}}})
    assert list(scenario.campaign.vary) == ["contact.height"]
    assert scenario.replace(campaign={"vary": {}}).campaign.vary == {}


@pytest.mark.parametrize(
    "change", [{"planner": None}, {"planer": {}}, {"planner.margin": -1}, {"contact": {"height": "high"}}]
)
def test_no_change_goes_unchecked(change):
    with pytest.raises(ScenarioError):
        Scenario.load("paper").replace(change)
    if not any("." in key for key in change):
        with pytest.raises(ScenarioError):
            Scenario.load("paper").model_copy(update=change)


def test_an_error_of_a_change_names_the_file(tmp_path):
    (tmp_path / "task.toml").write_text("")
    with pytest.raises(ScenarioError) as caught:
        Scenario.load(tmp_path / "task.toml").replace(planner__margin=-1)
    assert (caught.value.file, caught.value.field) == (str(tmp_path / "task.toml"), "planner.margin")


# ---------------------------------------------------------------- save


@given(
    margin=st.floats(0.0, 0.5),
    arm=st.none() | st.lists(st.floats(-6.0, 6.0), min_size=1, max_size=6),
    leaf=st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=8),
    key=st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=6).filter(lambda text: text != "same_as"),
    choice=st.lists(st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text("a\"\\\n\té", max_size=4),
                    min_size=1, max_size=3),
)  # fmt: skip
def test_a_saved_scenario_loads_as_the_same(tmp_path_factory, margin, arm, leaf, key, choice):
    overrides = {
        "planner.margin": margin,
        "start.arm": arm,
        "door.leaf": leaf,
        "campaign.vary": {key: {"choice": choice}},
    }
    scenario = Scenario.load("push", overrides)
    saved = scenario.save(tmp_path_factory.getbasetemp() / "saved" / "task.toml")
    assert (loaded := Scenario.load(saved)) == scenario
    assert hash(loaded) == hash(scenario)


@pytest.mark.parametrize("name", ["paper", "push", "push_campaign"])
def test_a_shipped_scenario_saves_and_loads_as_the_same(name, tmp_path):
    scenario = Scenario.load(name)
    assert Scenario.load(scenario.save(tmp_path / "a" / "b" / "task.toml")) == scenario
    assert Scenario.load(str(scenario.save(str(tmp_path / "plain.toml")))) == scenario


def test_files_are_found_from_the_new_place(tmp_path, monkeypatch):
    (tmp_path / "here").mkdir()
    door = write_door(tmp_path / "here" / "my door.urdf", mass=15.0)
    (tmp_path / "here" / "task.toml").write_text('[door]\nurdf = "my door.urdf"\n')
    monkeypatch.chdir(tmp_path)
    written = {
        "file": Scenario.load("here/task.toml"),
        "override": Scenario.load("paper", {"door.urdf": "here/my door.urdf"}),
    }
    for name, scenario in written.items():
        scenario.save(Path("there", f"{name}.toml"))
    (tmp_path / "link").symlink_to(tmp_path / "here")
    assert Scenario.load("link/task.toml") == written["file"]
    monkeypatch.chdir("/")
    for name, scenario in written.items():
        moved = Scenario.load(tmp_path / "there" / f"{name}.toml")
        assert moved == scenario and moved.door_urdf == door.resolve()
        assert moved.vehicle.urdf == "hexarotor_arm"


def test_what_cannot_be_saved_is_an_error_of_ours(tmp_path):
    for path in (tmp_path, tmp_path / "task.toml" / "task.toml"):
        (tmp_path / "task.toml").touch()
        with pytest.raises(ScenarioError, match="cannot be written"):
            Scenario().save(path)
    with pytest.raises(ScenarioError, match="no such URDF"):
        Scenario(door={"urdf": "lost.urdf"}).save(tmp_path / "other.toml")
    assert not (tmp_path / "other.toml").exists()


# ---------------------------------------------------------------- equality


def test_scenarios_are_keys(tmp_path):
    calls = []
    named = lru_cache(lambda scenario: calls.append(scenario.name))
    for scenario in (Scenario.load("paper"), Scenario.load("paper"), Scenario.load("push_campaign")):
        named(scenario)
    assert calls == ["paper", "push_campaign"]
    assert {Scenario(), Scenario(), Scenario().replace(contact__height=0.81)} == {
        Scenario(),
        Scenario().replace(contact__height=0.81),
    }
    assert Scenario.load("paper") != Scenario.load("push") and Scenario() != "default"
    assert hash(Scenario(contact={"height": 0.0})) == hash(Scenario(contact={"height": -0.0}))
    assert len({Scenario().contact, ContactSection(), ContactSection(height=math.e)}) == 2


def test_a_scenario_keeps_its_file_through_copies():
    scenario = Scenario.load("push")
    for copy in (scenario.model_copy(), scenario.model_copy(update={"contact": scenario.contact}),
                 pickle.loads(pickle.dumps(scenario))):  # fmt: skip
        assert copy == scenario and copy.source == scenario.source
