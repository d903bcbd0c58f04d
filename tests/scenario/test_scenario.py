"""Scenario files: defaults, overrides, and a clear error for everything that can be wrong in one."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from doorman.exceptions import DoormanError, ScenarioError
from doorman.model import Model
from doorman.resources import urdf_directory
from doorman.scenario import Scenario


@pytest.fixture
def write(tmp_path: Path):
    def to_file(text: str | bytes, name: str = "task.toml") -> Path:
        path = tmp_path / name
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return path

    return to_file


def fault(path: str | Path, **overrides: object) -> ScenarioError:
    with pytest.raises(ScenarioError) as caught:
        Scenario.load(path, overrides=overrides)
    return caught.value


# ---------------------------------------------------------------- what is right


def test_a_push_comes_nearer_to_the_hinge_in_a_narrow_doorway():
    def distance(**contact) -> float:
        given = {f"contact.{key}": value for key, value in contact.items()}
        return Model(Scenario.load("push", {"door.width": width, **given})).coupling.distance_from_hinge

    width = 1.1
    assert 0.5 < distance() < 0.6
    assert distance(kind="grip") == 0.7
    assert distance(distance_from_hinge=0.5) == 0.5
    width = 1.2
    assert distance() == 0.7


def test_a_push_ends_beside_the_normal_in_a_narrow_doorway():
    def goal(width: float, **contact) -> np.ndarray:
        given = {f"contact.{key}": value for key, value in contact.items()}
        model = Model(Scenario.load("push", {"door.width": width, "planner.margin": 0.04, **given}))
        assert contact or model.constraints(model.goal_state)[-2] < -0.08, "clear of the latch jamb"
        return model.goal_state

    assert [round(math.degrees(goal(width)[2])) for width in (1.1, 1.15, 1.3)] == [-57, -63, -70]
    assert goal(1.3, kind="grip")[2] == math.pi / 9 - math.pi / 2
    given = {"door.width": 1.1, "goal.attitude": [0.0, 0.0, -1.2]}
    assert Model(Scenario.load("push", given)).goal_state[2] == -1.2


def test_an_empty_file_is_the_default_task(write):
    scenario = Scenario.load(write(""))
    assert scenario.model_dump() == Scenario().model_dump()
    assert scenario.name == "task"


def test_overrides_win_over_the_file_and_reach_nested_tables(write):
    path = write("[contact]\nheight = 0.7\n[planner.weights]\nstate = [1.0]\n")
    scenario = Scenario.load(path, {"contact.height": 0.9, "planner.weights.input": (2.0, 3.0), "door.friction": 1})
    assert scenario.contact.height == 0.9
    assert scenario.planner.weights.state == (1.0,)
    assert scenario.planner.weights.input == (2.0, 3.0)
    assert scenario.door.friction == 1.0


def test_a_scenario_is_frozen():
    with pytest.raises(ValueError, match="frozen"):
        Scenario().contact.height = 0.1  # type: ignore[misc]


def test_urdf_paths_are_shipped_names_or_relative_to_the_file(write, tmp_path):
    (tmp_path / "doors").mkdir()
    own = tmp_path / "doors" / "own.urdf"
    own.write_text((urdf_directory() / "hinged_door.urdf").read_text())
    scenario = Scenario.load(write('[door]\nurdf = "doors/own.urdf"\n[vehicle]\nurdf = "hexarotor_arm"\n'))
    assert scenario.door_urdf == own.resolve()
    assert scenario.vehicle_urdf.samefile(urdf_directory() / "hexarotor_arm.urdf")
    assert Model(scenario).door.width == 1.2


# ---------------------------------------------------------------- what is wrong in a file

WRONG_VALUES = [
    # text, field, given, a word of what is allowed
    ("vehicle = 3", "vehicle", 3, "table"),
    ("[[planner]]\nrate = 1.0", "planner", [{"rate": 1.0}], "table"),
    ('[contact]\nheight = "high"', "contact.height", "high", "number"),
    ("[contact]\nheight = -0.1", "contact.height", -0.1, "greater than or equal to 0"),
    ("[contact]\nheight = inf", "contact.height", math.inf, "finite"),
    ("[contact]\nheight = 1979-05-27", "contact.height", None, "number"),
    ('[contact]\nkind = "pull"', "contact.kind", "pull", "'grip' or 'push'"),
    ("[planner]\nhorizon_steps = 50.0", "planner.horizon_steps", 50.0, "integer"),
    (f"[planner]\nhorizon_steps = {10**30}", "planner.horizon_steps", 10**30, "less than or equal"),
    (f"[contact]\nheight = {10**400}", "contact.height", 10**400, "number"),
    ("[planner.weights]\ninput = [1.0, 0.0]", "planner.weights.input.1", 0.0, "greater than 0"),
    ("[goal]\ndoor_angle = 7.0", "goal.door_angle", 7.0, "less than or equal to"),
    ("[goal]\nattitude = [0.0, 0.0, 0.0, 0.0]", "goal.attitude", None, "shorter list"),
    ('[start]\narm = "straight"', "start.arm", "straight", "list"),
    ("[vehicle]\nurdf = 3", "vehicle.urdf", 3, "string"),
]


@pytest.mark.parametrize(("text", "field", "given", "allowed"), WRONG_VALUES, ids=[row[0] for row in WRONG_VALUES])
def test_a_wrong_value_names_file_field_given_and_allowed(write, text, field, given, allowed):
    path = write(text)
    error = fault(path)
    assert error.file == str(path)
    assert error.field == field
    if given is not None:
        assert error.given == given
    assert error.given is not None
    assert allowed in error.allowed
    assert all(part in str(error) for part in (str(path), field, "given", "allowed"))
    assert len(str(error)) < 400 + len(str(path))


@pytest.mark.parametrize(
    ("text", "field", "nearest"),
    [
        ("[contcat]\nheight = 0.8", "contcat", "contact"),
        ("[contact]\ndistance_form_hinge = 0.7", "contact.distance_form_hinge", "distance_from_hinge"),
        ("[planner.weights]\nstates = [1.0]", "planner.weights.states", "state"),
        ("[simulation.noise]\npostion = 0.0", "simulation.noise.postion", "position"),
        ("planer = 100.0", "planer", "planner"),
    ],
)
def test_an_unknown_key_names_its_nearest_neighbour(write, text, field, nearest):
    error = fault(write(text))
    assert error.field == field
    assert f"the nearest is '{nearest}'" in str(error)
    assert nearest in error.allowed.split(", ")


def test_further_faults_are_counted(write):
    assert "and 1 more" in str(fault(write("[contact]\nheight = nan\nwidth = 2.0\n")))


BROKEN = {
    "syntax": "[contact\nheight = 0.8",
    "not UTF-8": b"[contact]\nkind = '\xff\xfe'",
    "integer of 5000 digits": "[planner]\nhorizon_steps = " + "9" * 5000,
    "nested too deeply": "x = " + "[" * 3000,
    "zero byte": b"a = 1\x00",
}


@pytest.mark.parametrize("text", BROKEN.values(), ids=BROKEN)
def test_what_is_not_toml_is_an_error_of_the_file(write, text):
    path = write(text)
    error = fault(path)
    assert error.file == str(path)
    assert "not valid TOML" in str(error)
    assert "TOML" in error.allowed


def test_a_missing_scenario_suggests_a_shipped_one():
    error = fault("papr")
    assert "did you mean 'paper'?" in str(error)
    assert all(name in error.allowed for name in ("gate, ", "paper, ", "push, "))


@pytest.mark.parametrize("source", ["", "no/such/file.toml", "x" * 5000, "a\0b"])
def test_an_impossible_path_is_an_error(source):
    assert fault(source).given is not None


def test_an_override_below_a_value_is_an_error(write):
    error = fault(write("[contact]\nheight = 0.8\n"), **{"contact.height.above": 1.0})
    assert error.field == "contact.height.above"
    assert error.given == "height"


# ---------------------------------------------------------------- what a file points at


def test_a_missing_urdf_names_the_field_and_the_shipped_ones(write):
    path = write('[vehicle]\nurdf = "octarotor.urdf"\n')
    with pytest.raises(DoormanError) as caught:
        Model(Scenario.load(path))
    error = caught.value
    assert (error.file, error.field, error.given) == (str(path), "vehicle.urdf", "octarotor.urdf")
    assert "hexarotor_arm" in error.allowed


def test_a_name_that_the_urdf_lacks_can_be_mapped(tmp_path):
    text = (urdf_directory() / "hexarotor_arm.urdf").read_text(encoding="utf-8")
    renamed = text.replace('"base_link"', '"body"').replace('"tip"', '"finger"')
    (tmp_path / "vehicle.urdf").write_text(renamed, encoding="utf-8")
    (tmp_path / "task.toml").write_text('[vehicle]\nurdf = "vehicle.urdf"\nbase_link = "body"\ntip = "finger"\n')
    mapped, shipped = Model(Scenario.load(tmp_path / "task.toml")), Model(Scenario())
    np.testing.assert_array_equal(mapped.constraints(mapped.start_state), shipped.constraints(shipped.start_state))


@pytest.mark.parametrize(
    ("key", "value", "allowed"),
    [
        ("contact.distance_from_hinge", 1.3, "1.2 m"),
        ("contact.height", 1.7, "1.6 m"),
        ("start.arm", [0.0, 0.0], "4, the joints"),
        ("goal.arm", [0.0] * 5, "4, the joints"),
    ],
)
def test_what_does_not_fit_the_urdfs_is_an_error_of_the_scenario(key, value, allowed):
    with pytest.raises(ScenarioError) as caught:
        Model(Scenario.load("paper", {key: value}))
    assert caught.value.field == key
    assert caught.value.given is not None
    assert allowed in caught.value.allowed
