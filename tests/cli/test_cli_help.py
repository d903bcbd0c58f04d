"""Help, completion and version."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
from command_line import COMMAND, ROOT, run

import doorman

COMMANDS = "open check warmup rig fly campaign view export plot replay estimate merge list doctor"


@pytest.mark.parametrize("command", COMMANDS.split())
def test_every_command_gives_its_result_as_json(command):
    assert command in run("--help").output
    assert "--json" in run(command, "--help").output


def complete(*words: str, folder: Path) -> list[str]:
    """What bash is offered for the last word."""
    asked = {"COMP_WORDS": " ".join(["doorman", *words]), "COMP_CWORD": str(len(words))}
    environment = {"_DOORMAN_COMPLETE": "complete_bash", **asked}
    ran = subprocess.run(
        COMMAND, cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT), **environment}, capture_output=True, text=True,
        timeout=120, check=False,
    )  # fmt: skip
    assert ran.stderr == ""
    return ran.stdout.split()


def test_the_shell_completes_commands_scenarios_and_keys(tmp_path):
    (tmp_path / "task.toml").write_text("")
    (tmp_path / "doors").mkdir()
    (tmp_path / "doors" / "heavy.toml").write_text("")
    assert complete("cam", folder=tmp_path) == ["campaign"]
    assert complete("open", "pus", folder=tmp_path) == "push push_campaign push_left push_small push_tilted".split()
    assert complete("check", "ta", folder=tmp_path) == ["task.toml"]
    assert complete("open", "doors/", folder=tmp_path) == ["doors/heavy.toml"]
    assert complete("open", "--real", folder=tmp_path) == ["--realtime"]
    keys = complete("open", "--set", "planner.weights.", folder=tmp_path)
    assert keys == ["planner.weights.state=", "planner.weights.input="]


def test_the_completion_script_is_one_that_bash_takes(tmp_path):
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "_DOORMAN_COMPLETE": "source_bash"}
    script = subprocess.run(COMMAND, env=environment, capture_output=True, text=True, timeout=120, check=True).stdout
    (tmp_path / "completion.sh").write_text(script)
    asked = f"source {tmp_path / 'completion.sh'} && complete -p doorman"
    ran = subprocess.run(["bash", "-c", asked], capture_output=True, text=True, timeout=60, check=False)
    assert ran.returncode == 0 and "doorman" in ran.stdout, ran.stderr


def test_the_version():
    result = run("--version")
    assert (result.exit_code, result.stdout) == (0, f"doorman {doorman.__version__}\n")
