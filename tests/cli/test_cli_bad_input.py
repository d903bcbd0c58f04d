"""Bad input: one line on stderr and exit status 2, whatever is wrong with it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import ROOT, assert_bad_input, run, start

from doorman.resources import urdf_directory


@pytest.fixture(params=["open", "check", "warmup"])
def command(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    return request.param


BAD_SCENARIOS = {
    "wrong type": ('[contact]\nheight = "high"', ["contact.height", "given 'high'", "allowed: a number"]),
    "unknown key": ("[planner]\nmargins = 0.01", ["planner.margins", "nearest is 'margin'"]),
    "not a number": ("[start]\ndoor_angle = nan", ["start.door_angle", "given nan", "finite"]),
    "infinite": ("[planner]\nrate = inf", ["planner.rate", "given inf", "finite"]),
    "out of range": ("[planner]\nmargin = -0.1", ["planner.margin", "given -0.1", "greater than or equal to 0"]),
    "boolean": ("[planner]\nrate = true", ["planner.rate", "given True", "a number"]),
    "huge integer": (f"[planner]\niterations = {10**40}", ["planner.iterations", "less than or equal to"]),
    "section that is a value": ("planner = 3", ["planner", "given 3", "a table"]),
    "syntax": ("[planner\n", ["not valid TOML"]),
    "not UTF-8": ("\xff".encode("latin-1"), ["not valid TOML", "UTF-8"]),
    "off the leaf": ("[contact]\ndistance_from_hinge = 1.5", ["contact.distance_from_hinge", "given 1.5", "1.2 m"]),
    "wrong number of angles": ("[goal]\narm = [0.0]", ["goal.arm", "given 1", "allowed: 4"]),
    "missing URDF": ('[door]\nurdf = "gone.urdf"', ["door.urdf", "given 'gone.urdf'", "hinged_door"]),
}


@pytest.mark.parametrize(("text", "words"), BAD_SCENARIOS.values(), ids=BAD_SCENARIOS)
def test_a_bad_scenario_is_one_line_and_status_2(command, text, words):
    Path("task.toml").write_bytes(text if isinstance(text, bytes) else text.encode())
    assert_bad_input(run(command, "task.toml"), "task.toml", *words)
    assert not Path("runs").exists()


BAD_URDFS = {
    "malformed": ("</robot>", "", ["not well-formed XML"]),
    "not a URDF": ("robot", "model", ["root element", "given 'model'", "allowed: <robot>"]),
    "no leaf": ('"leaf"', '"slab"', ["door.leaf", "given 'leaf'", "slab"]),
    "no hinge": ('joint name="hinge"', 'joint name="pivot"', ["hinge", "pivot"]),
    "no mass": ('<mass value="11"/>', '<mass value="0"/>', ["leaf", "mass", "given 0.0", "> 0 kg"]),
    "no number": ('<mass value="11"/>', '<mass value="nan"/>', ["mass", "given 'nan'", "finite"]),
}


@pytest.mark.parametrize(("old", "new", "words"), BAD_URDFS.values(), ids=BAD_URDFS)
def test_a_bad_urdf_is_one_line_and_status_2(command, old, new, words):
    text = (urdf_directory() / "hinged_door.urdf").read_text(encoding="utf-8")
    Path("door.urdf").write_text(text.replace(old, new), encoding="utf-8")
    assert_bad_input(run(command, "--set", "door.urdf=door.urdf"), "door.urdf", *words)
    assert not Path("runs").exists()


def test_an_unknown_scenario_is_one_line_and_status_2(command):
    assert_bad_input(run(command, "papr"), "given 'papr'", "did you mean 'paper'?")
    assert_bad_input(run(command, "."), "given '.'", "path of a TOML file")


def test_a_bad_override_is_one_line_and_status_2(command):
    assert_bad_input(run(command, "--set", "planner.margin"), "--set", "KEY=VALUE")
    assert_bad_input(run(command, "--set", "planner.margin=[1"), "--set planner.margin", "given '[1'")
    assert_bad_input(run(command, "--set", "planner.margn=0.1"), "planner.margn", "nearest is 'margin'")
    assert_bad_input(run(command, "--set", "a\nb=1"), "--set")


@pytest.mark.parametrize("duration", ["nan", "inf", "-1", "0", "1e9"])
def test_a_bad_duration_is_one_line_and_status_2(duration):
    assert_bad_input(run("open", "--duration", duration), "--duration", "3600")


@pytest.mark.parametrize(
    "arguments", [["open", "--seed", "-1"], ["open", "--duration", "long"], ["fly"], ["check", "--out", "x"]]
)
def test_bad_usage_has_status_2(arguments):
    result = run(*arguments)
    assert result.exit_code == 2
    assert "Usage" in result.stderr


def test_an_output_folder_that_is_a_file_is_one_line_and_status_2(tmp_path):
    (tmp_path / "taken").write_text("x")
    assert_bad_input(run("open", "--out", str(tmp_path / "taken")), "taken")
    assert_bad_input(run("open", "--out", str(tmp_path / "taken" / "below")), "taken")
    assert (tmp_path / "taken").read_text() == "x"


def test_a_process_leaves_with_status_2_and_no_traceback(tmp_path):
    (tmp_path / "task.toml").write_text("[planner]\nmargin = nan\n")
    process = start("open", "task.toml", folder=tmp_path)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (2, "")
    assert err.startswith("doorman: error: ") and err.count("\n") == 1 and "planner.margin" in err
    assert [path.name for path in tmp_path.iterdir()] == ["task.toml"]


def test_a_missing_extra_is_named(tmp_path):
    code = "import sys; sys.modules['mujoco'] = None; from doorman.cli import main; main()"
    ran = subprocess.run(
        [sys.executable, "-c", code, "open", "--out", "run"], cwd=tmp_path, capture_output=True, text=True, timeout=120,
        env={**os.environ, "PYTHONPATH": str(ROOT)}, check=False,
    )  # fmt: skip
    assert ran.returncode == 2
    assert "pip install -e '.[sim]'" in ran.stderr and ran.stderr.count("\n") == 1
