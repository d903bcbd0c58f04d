"""Which file a value means: the user's own at a path, a shipped one by a bare name, and never one instead of the other."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import assert_bad_input, run
from urdf_variants import VEHICLE, write_door

from doorman.campaign import Campaign
from doorman.exceptions import ScenarioError
from doorman.kinematics.doors.door import Door
from doorman.resources import scenario_directory, urdf_directory
from doorman.scenario import Scenario
from doorman.scenario.files import SHIPPED

HEAVY = 17.25


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, empty."""
    folder = tmp_path / "here"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def task(tmp_path: Path) -> Path:
    """A scenario's file in another directory."""
    (tmp_path / "tasks").mkdir()
    return tmp_path / "tasks" / "task.toml"


def mass(scenario: Scenario) -> float:
    return Door(scenario.door_urdf).mass


def refused(source: str | Path, **overrides: str) -> ScenarioError:
    with pytest.raises(ScenarioError) as caught:
        scenario = Scenario.load(source, {key.replace("__", "."): value for key, value in overrides.items()})
        print(scenario.vehicle_urdf, scenario.door_urdf)
    return caught.value


# ---------------------------------------------------------------- URDFs in a file


@pytest.mark.parametrize(
    "name", ["hinged_door.urdf", "./hinged_door.urdf", "doors/hinged_door.urdf", "hinged_door.xml"]
)
def test_a_path_is_the_users_own_file(task, here, name):
    task.write_text(f'[door]\nurdf = "{name}"\n')
    (task.parent / name).parent.mkdir(exist_ok=True)
    write_door(task.parent / name, mass=HEAVY)
    assert mass(Scenario.load(task)) == HEAVY


def test_a_path_is_not_looked_for_elsewhere(task, here):
    task.write_text('[door]\nurdf = "hinged_door.urdf"\n')
    write_door(here / "hinged_door.urdf", mass=HEAVY)
    error = refused(task)
    assert (error.file, error.field, error.given) == (str(task), "door.urdf", "hinged_door.urdf")
    assert "'hinged_door'" in str(error) and str(task.parent) in error.allowed


@pytest.mark.parametrize("where", ["beside the file", "in the working directory"])
@pytest.mark.parametrize("own", ["hinged_door.urdf", "hinged_door"])
def test_a_bare_name_of_two_files_is_refused_and_either_can_be_written(task, here, own, where):
    folder = task.parent if where == "beside the file" else here
    write_door(folder / own, mass=HEAVY)
    task.write_text('[door]\nurdf = "hinged_door"\n')
    error = refused(task)
    assert (error.file, error.field, error.given) == (str(task), "door.urdf", "hinged_door")
    mine, theirs = (word for word in error.allowed.split("'") if "hinged" in word)
    for written, expected in ((mine, HEAVY), (theirs, 11.0)):
        task.write_text(f'[door]\nurdf = "{written}"\n')
        assert mass(Scenario.load(task)) == expected


def test_a_default_is_a_bare_name_too(here):
    (here / "hexarotor_arm.urdf").write_text(VEHICLE.read_text())
    assert refused("paper").field == "vehicle.urdf"
    assert Scenario.load("paper", {"vehicle.urdf": f"{SHIPPED}hexarotor_arm"}).vehicle_urdf.parent == urdf_directory()


def test_a_bare_name_that_is_not_shipped_says_how_to_write_the_own_file(task, here):
    write_door(task.parent / "portal", mass=HEAVY)
    task.write_text('[door]\nurdf = "portal"\n')
    assert "'./portal'" in str(refused(task))
    task.write_text('[door]\nurdf = "./portal"\n')
    assert mass(Scenario.load(task)) == HEAVY


def test_a_directory_of_a_shipped_name_is_no_other_file(here):
    for name in ("hinged_door", "paper", "push.toml"):
        (here / name).mkdir()
    assert mass(Scenario.load("paper")) == 11.0
    assert Scenario.load("push").contact.kind == "push"


@pytest.mark.parametrize("folder", [urdf_directory(), scenario_directory()])
def test_the_shipped_files_do_not_hide_themselves(folder, monkeypatch):
    monkeypatch.chdir(folder)
    assert mass(Scenario.load("push")) == 11.0


# ---------------------------------------------------------------- URDFs in overrides and in Python


def test_a_path_in_an_override_is_relative_to_the_working_directory(task, here, monkeypatch, tmp_path):
    task.write_text("")
    write_door(here / "mine.urdf", mass=HEAVY)
    write_door(task.parent / "theirs.urdf", mass=12.0)
    assert mass(Scenario.load(task, {"door.urdf": "../tasks/theirs.urdf"})) == 12.0
    scenario, nested = (
        Scenario.load(task, {"door.urdf": "mine.urdf"}),
        Scenario.load(task, {"door": {"urdf": "mine.urdf"}}),
    )
    replaced = Scenario.load(task).replace(door={"urdf": Path("mine.urdf")})
    monkeypatch.chdir(tmp_path)
    assert mass(scenario) == mass(nested) == mass(replaced) == HEAVY
    assert refused(task, door__urdf="theirs.urdf").field == "door.urdf"


def test_drawn_files_are_relative_to_the_scenarios_file(task, here):
    for name in ("light", "heavy"):
        write_door(task.parent / f"{name}.urdf", mass=HEAVY)
    task.write_text('[campaign.vary]\ndoor.urdf = { choice = ["light.urdf", "heavy.urdf"] }\n')
    for flight in Campaign(str(task)).flights(4):
        assert mass(flight.scenario) == HEAVY
    saved = Scenario.load(Scenario.load(task).save(here / "copy.toml"))
    assert all(Path(str(path)).is_file() for path in saved.campaign.vary["door.urdf"].choice or ())


# ---------------------------------------------------------------- scenarios


@pytest.mark.parametrize("own", ["push.toml", "push"])
def test_a_bare_scenario_of_two_files_is_refused_and_either_can_be_written(here, own):
    (here / own).write_text("[contact]\nheight = 0.6\n")
    error = refused("push")
    mine, theirs = (word for word in error.allowed.split("'") if "push" in word)
    assert Scenario.load(mine).contact.height == 0.6
    assert Scenario.load(theirs).contact.kind == "push"
    assert_bad_input(run("check", "push"), "push", mine, theirs)


def test_a_path_of_a_scenario_is_the_users_own(here):
    (here / "paper.toml").write_text("[contact]\nheight = 0.6\n")
    for written in ("paper.toml", "./paper.toml", here / "paper.toml", Path("paper.toml")):
        assert Scenario.load(written).contact.height == 0.6
    assert "'paper'" in str(refused("elsewhere/paper.toml"))


# ---------------------------------------------------------------- encodings


def test_a_byte_order_mark_is_no_value(task, here):
    write_door(task.parent / "tür.urdf", mass=HEAVY)
    task.write_text('[door]\nurdf = "tür.urdf"\n', encoding="utf-8-sig")
    assert mass(Scenario.load(task)) == HEAVY
