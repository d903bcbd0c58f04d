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
    "syntax": ("[planner\n", ["not valid TOML"]),
    "off the leaf": ("[contact]\ndistance_from_hinge = 1.5", ["contact.distance_from_hinge", "given 1.5", "1.2 m"]),
    "missing URDF": ('[door]\nurdf = "gone.urdf"', ["door.urdf", "given 'gone.urdf'", "hinged_door"]),
}
"""What may be wrong with a value is shown in `tests/scenario`."""


@pytest.mark.parametrize(("text", "words"), BAD_SCENARIOS.values(), ids=BAD_SCENARIOS)
def test_a_bad_scenario_is_one_line_and_status_2(command, text, words):
    Path("task.toml").write_text(text)
    assert_bad_input(run(command, "task.toml"), "task.toml", *words)
    assert not Path("runs").exists()


BAD_URDFS = {
    "malformed": ("</robot>", "", ["not well-formed XML"]),
    "no leaf": ('"leaf"', '"slab"', ["door.leaf", "given 'leaf'", "slab"]),
}


@pytest.mark.parametrize(("old", "new", "words"), BAD_URDFS.values(), ids=BAD_URDFS)
def test_a_bad_urdf_is_one_line_and_status_2(command, old, new, words):
    text = (urdf_directory() / "hinged_door.urdf").read_text(encoding="utf-8")
    Path("door.urdf").write_text(text.replace(old, new), encoding="utf-8")
    assert_bad_input(run(command, "--set", "door.urdf=door.urdf"), "door.urdf", *words)
    assert not Path("runs").exists()


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
