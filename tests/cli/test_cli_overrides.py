"""Overrides on the command line, and the scenario that comes of them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from doorman.cli.values import parse_overrides
from doorman.exceptions import ScenarioError
from doorman.resources import urdf_directory
from doorman.scenario import Scenario


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("planner.margin=0.01", "planner.margin", 0.01),
        ("contact.kind=push", "contact.kind", "push"),
        ('contact.kind="push"', "contact.kind", "push"),
        ("door.urdf=../doors/heavy.urdf", "door.urdf", "../doors/heavy.urdf"),
        ("door.urdf=my doors/heavy-2.urdf", "door.urdf", "my doors/heavy-2.urdf"),
        ("start.arm=[0, 1.0, -0.6, -0.4]", "start.arm", [0, 1.0, -0.6, -0.4]),
        (" planner.horizon_steps = 20 ", "planner.horizon_steps", 20),
        ("x=true", "x", True),
        ("mocap.sender=192.168.10.5", "mocap.sender", "192.168.10.5"),
        ("x={a = 1}", "x", {"a": 1}),
        ('x="a=b"', "x", "a=b"),
    ],
)
def test_the_value_of_an_override_is_toml_or_a_bare_word(text, key, value):
    assert parse_overrides([text]) == {key: value}


def test_the_last_override_of_a_key_wins():
    assert parse_overrides(["a.b=1", "c=2", "a.b=3"]) == {"a.b": 3, "c": 2}


@pytest.mark.parametrize(
    "text",
    ["", "=", "=3", "planner.margin", "planner margin=1", "a..b=1", ".a=1", "a=", "a=[1", 'a="b', "a=1 2", "a=1\nb = 2",
     "a=1.2.3", "a=# comment", "a='", "[a]=1", "a=" + "[" * 3000, "a=" + "9" * 5000],
    ids=lambda text: repr(text[:20]),
)  # fmt: skip
def test_what_is_no_override_is_an_error(text):
    with pytest.raises(ScenarioError) as caught:
        parse_overrides([text])
    assert caught.value.field.startswith("--set")
    assert caught.value.given is not None
    assert caught.value.allowed is not None


@given(
    height=st.floats(0.0, 1.6),
    arm=st.none() | st.lists(st.floats(-3.0, 3.0), min_size=4, max_size=4),
    kind=st.sampled_from(["grip", "push"]),
    noise=st.floats(0.0, 1e-300) | st.floats(0.0, 1e300),
    name=st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=8),
)
def test_the_effective_scenario_loads_as_the_same(tmp_path_factory, height, arm, kind, noise, name):
    overrides = {"contact.height": height, "contact.kind": kind, "simulation.noise.position": noise, "door.leaf": name}
    if arm is not None:
        overrides["start.arm"] = arm
    scenario = Scenario.load("paper", overrides)
    path = tmp_path_factory.getbasetemp() / "effective.toml"
    path.write_text(scenario.toml(), encoding="utf-8")
    assert Scenario.load(path).model_dump() == scenario.model_dump()


def test_the_effective_scenario_finds_its_urdfs_from_elsewhere(tmp_path):
    (tmp_path / "here").mkdir()
    (tmp_path / "there").mkdir()
    (tmp_path / "here" / "my door.urdf").write_text((urdf_directory() / "hinged_door.urdf").read_text(encoding="utf-8"))
    (tmp_path / "here" / "task.toml").write_text('[door]\nurdf = "my door.urdf"\n')
    (tmp_path / "there" / "task.toml").write_text(Scenario.load(tmp_path / "here" / "task.toml").toml())
    moved = Scenario.load(tmp_path / "there" / "task.toml")
    assert moved.door_urdf == (tmp_path / "here" / "my door.urdf").resolve()
    assert moved.vehicle.urdf == "hexarotor_arm"
