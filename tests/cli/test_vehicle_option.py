"""`--vehicle`: every command that takes it flies that vehicle, or says what is wrong with its file."""

from __future__ import annotations

import shutil

import pytest
from command_line import assert_bad_input, run

from doorman.cli.task import load_task
from doorman.resources import urdf_directory
from doorman.scenario import Scenario

COMMANDS = [
    ["check", "paper"], ["open", "paper"], ["warmup", "paper"], ["rig", "paper"], ["fly", "paper"], ["parameters", "px4"],
    ["doctor"], ["ros2"], ["campaign", "push_campaign"],
]  # fmt: skip


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_a_wrong_key_is_an_error_of_every_command(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my.toml").write_text("[servos]\nidz = [1]\n")
    assert_bad_input(run(*command, "--vehicle", "my.toml"), "my.toml: servos.idz", "nearest is 'ids'")
    assert_bad_input(run(*command, "--vehicle", "none.toml"), "none.toml", "no such vehicle", "rig")


@pytest.mark.parametrize(
    "command",
    [["check", "paper"], ["open", "paper"], ["parameters", "px4"], ["rig", "paper"], ["campaign", "push_campaign"]],
    ids=" ".join,
)
def test_a_link_that_cannot_be_is_an_error_before_anything_flies(command, tmp_path):
    path = tmp_path / "my.toml"
    path.write_text('[servos]\ndirections = [1, 1, 2, 1, 1]\nport = "/dev/arm"\n')
    assert_bad_input(run(*command, "--vehicle", str(path)), "my.toml: servos.directions", "1 or -1")


def test_what_is_flown_is_the_file_s_vehicle(tmp_path):
    shutil.copy(urdf_directory() / "hexarotor_arm.urdf", tmp_path / "mine.urdf")
    path = tmp_path / "my.toml"
    path.write_text(
        '[vehicle]\nurdf = "mine.urdf"\nattitude_lag = 0.07\n[control]\nmax_tilt = 0.21\nobserver_rate = 2.0\n'
    )
    flown = load_task("paper", ["control.observer_rate=1.5"], str(path))
    assert flown.vehicle_urdf == (tmp_path / "mine.urdf").resolve()
    assert (flown.vehicle.attitude_lag, flown.control.max_tilt, flown.control.observer_rate) == (0.07, 0.21, 1.5)
    assert load_task("paper", [], None) == Scenario.load("paper")


def test_a_new_file_is_written_once_and_beside_its_urdf(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(urdf_directory() / "hexarotor_arm.urdf", tmp_path / "mine.urdf")
    (tmp_path / "files").mkdir()
    assert run("vehicle", "new", "files/my.toml", "--urdf", "mine.urdf", "--all").exit_code == 0
    text = (tmp_path / "files" / "my.toml").read_text(encoding="utf-8")
    assert 'urdf = "../mine.urdf"' in text and "# baud_rate = 1000000" in text
    assert_bad_input(run("vehicle", "new", "files/my.toml"), "files/my.toml", "exists")
    assert (tmp_path / "files" / "my.toml").read_text(encoding="utf-8") == text
    assert_bad_input(run("vehicle", "new", "other.toml", "--urdf", "mine.urdf", "--tip", "finger"), "finger")
    assert_bad_input(run("vehicle", "new", "other.toml", "--urdf", "nope.urdf"), "--urdf", "nope.urdf")
    assert not (tmp_path / "other.toml").exists()


def test_links_are_named_by_the_command_line_or_by_a_file():
    result = run("fly", "paper")
    assert result.exit_code == 2 and "Usage" in result.stderr and "--vehicle" in result.stderr
