"""The command line as tests call it: in this process or in one of its own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

from typer.testing import CliRunner, Result

from doorman.cli import app

ROOT = Path(__file__).parents[2]
COMMAND = [sys.executable, "-c", "from doorman.cli import main; main()"]


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, list(arguments), env={"COLUMNS": "100", "TERM": "dumb"})


def start(*arguments: str, folder: Path) -> subprocess.Popen[str]:
    """The command in a process of its own, with Ctrl-C as in a terminal whatever this process does with it."""
    return subprocess.Popen(
        [*COMMAND, *arguments], cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)}, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip


def assert_bad_input(result: Result, *words: str) -> None:
    """One line on stderr, nothing on stdout, exit status 2, and no exception that escaped."""
    assert result.exit_code == 2, result.output
    assert isinstance(result.exception, SystemExit)
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert result.stderr.startswith("doorman: error: ")
    assert "Traceback" not in result.stderr
    for word in words:
        assert word in result.stderr, result.stderr
