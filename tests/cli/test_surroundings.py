"""Odd surroundings: whatever they are, a sentence comes of it, and a status that nobody takes for an answer."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from command_line import COMMAND, ROOT, run

from doorman.cli.command import BAD_INPUT, FAULT, INTERRUPTED
from doorman.model import Model

PRINT = """
from doorman.cli.terminal.streams import steady_streams
steady_streams()
print("20.0° → α ± 1 × 2 ≥ 0 — 漢 \\udcff")
"""


TABLE = f"""{sys.executable} -c '
import sys
from rich.console import Console
from doorman.cli import app, main
leave = sys.modules["doorman.cli.command"].leave

@app.command("table")
def table():
    leave(lambda: Console().print("20.0°", "→") or 0)

sys.argv = ["doorman", "table"]
main()'"""
"""A command that prints as all do."""


def bash(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["bash", "-c", command], cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True,
        timeout=300, check=False,
    )  # fmt: skip


@pytest.mark.parametrize("encoding", ["latin-1", "ascii", "cp1252", "utf-8"])
def test_any_text_is_written_in_any_encoding(encoding):
    ran = subprocess.run(
        [sys.executable, "-c", PRINT], env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": encoding},
        capture_output=True, timeout=120, check=False,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    text = ran.stdout.decode(encoding).rstrip()
    if encoding == "utf-8":
        assert text == "20.0° → α ± 1 × 2 ≥ 0 — 漢 ?"
    elif encoding == "ascii":
        assert text == "20.0 deg -> alpha +- 1 x 2 >= 0 ? ? ?"
    else:
        assert "-> alpha" in text and "20.0°" in text


@pytest.mark.parametrize(
    ("redirected", "status", "words"),
    [
        ("| exec 0<&-; exit ${PIPESTATUS[0]}", BAD_INPUT, "stdout: its reader has closed it"),
        (">/dev/full", BAD_INPUT, "stdout or a file: No space left on device"),
        (">&-", 0, ""),
        ("<&- >&-", 0, ""),
    ],
)
def test_output_that_nobody_takes_is_a_sentence_and_no_answer(redirected, status, words, tmp_path):
    """A pipe whose reader has left, a full disk; a stream that was never there is not missed."""
    ran = bash(f"{TABLE} {redirected}", tmp_path)
    assert "Traceback" not in ran.stderr and "Exception ignored" not in ran.stderr
    assert words in ran.stderr and ran.stderr.count("\n") == (1 if words else 0)
    assert ran.returncode == status


def test_a_file_does_not_get_the_number_of_a_closed_stream(tmp_path):
    """Else whatever a library prints goes into the recording."""
    streams = "from doorman.cli.terminal.streams import *; steady_streams()"
    code = f"{streams}; print(open('a', 'w').fileno(), file=open('number', 'w'))"
    bash(f'{sys.executable} -c "{code}" <&- >&- 2>&-', tmp_path)
    assert int((tmp_path / "number").read_text()) > 2


@pytest.mark.parametrize(
    ("fault", "status", "words"),
    [
        (EOFError("EOF when reading a line"), BAD_INPUT, "stdin"),
        (UnicodeEncodeError("latin-1", "→", 0, 1, "ordinal not in range"), BAD_INPUT, "cannot be read or written"),
        (OSError(errno.ENOSPC, "No space left", "run/summary.json"), BAD_INPUT, "run/summary.json: No space left"),
        (OSError("a device of its own"), BAD_INPUT, "a device of its own"),
        (ModuleNotFoundError("No module named 'left_pad'", name="left_pad"), BAD_INPUT, "left_pad is not installed"),
        (ValueError("Key: 'nonsense'\nis not valid"), FAULT, "ValueError: Key: 'nonsense' is not valid"),
        (RecursionError("too deep"), FAULT, "RecursionError"),
        (MemoryError(), FAULT, "MemoryError"),
        (KeyboardInterrupt(), INTERRUPTED, "interrupted."),
    ],
)
def test_no_fault_is_taken_for_an_answer_of_check(monkeypatch, fault, status, words):
    def fails(*_: object, **__: object) -> int:
        raise fault

    monkeypatch.setattr("doorman.feasibility.check", fails)
    result = run("check", "paper")
    assert (result.exit_code, result.stdout) == (status, "")
    assert words in result.stderr and result.stderr.count("\n") == 1 and result.stderr.startswith("doorman: ")


def test_a_fault_shows_where_when_asked_to(monkeypatch):
    def fails(*_: object, **__: object) -> int:
        raise ZeroDivisionError("a fault")

    monkeypatch.setattr("doorman.feasibility.check", fails)
    monkeypatch.setenv("DOORMAN_TRACEBACK", "1")
    assert isinstance(run("check", "paper").exception, ZeroDivisionError)


def test_a_second_ctrl_c_while_the_first_is_told_is_none(monkeypatch):
    def fails(*_: object, **__: object) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr("doorman.feasibility.check", fails)
    monkeypatch.setattr(sys.modules["doorman.cli.command"], "_complain", fails)
    assert run("check", "paper").exit_code == INTERRUPTED


@pytest.mark.parametrize("pause", [0.0, 0.2])
def test_two_early_ctrl_c_are_a_sentence_and_no_answer(pause, tmp_path):
    process = subprocess.Popen(
        [*COMMAND, "check", "paper"], cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)}, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    maps = Path(f"/proc/{process.pid}/maps")
    deadline = time.monotonic() + 60.0
    while "libpinocchio" not in maps.read_text() and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    time.sleep(pause)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=120)
    assert process.returncode in (INTERRUPTED, -signal.SIGINT), err
    assert "Traceback" not in err and out == ""


def test_nobody_to_answer_is_a_no(monkeypatch):
    from doorman.cli.vehicles.flight import Mission

    with open(os.devnull, encoding="utf-8") as nobody:
        monkeypatch.setattr(sys, "stdin", nobody)
        assert Mission(Model("paper"), aside=True).confirmed() is False
