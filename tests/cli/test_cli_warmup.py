"""`doorman warmup`: what it says of the cache, and its progress."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from io import StringIO
from pathlib import Path

import pytest
from command_line import ROOT, run
from rich.console import Console

from doorman.cli.simulated.warmup import planners_ahead
from doorman.cli.terminal.display import flight_progress, warmup_progress
from doorman.compilation import KernelCounts, cache_content


def test_warmup_as_json():
    run("warmup", "paper")
    before = cache_content()
    figures = json.loads(run("warmup", "paper", "--set", "planner.margin=0.02", "--json").stdout)
    after = cache_content()
    assert (figures["compiled"], figures["loaded"]) == (0, 0)  # this process has them all
    assert before.kernels <= figures["cache_kernels"] <= after.kernels
    assert before.size <= figures["cache_bytes"] <= after.size
    assert Path(figures["cache_directory"]) == after.directory
    assert figures["seconds"] > 0.0


def test_warmup_does_without_the_simulator(tmp_path):
    code = "import sys; sys.modules['mujoco'] = None; from doorman.cli import main; main()"
    ran = subprocess.run(
        [sys.executable, "-c", code, "warmup", "paper"], cwd=tmp_path, capture_output=True, text=True, timeout=600,
        env={**os.environ, "PYTHONPATH": str(ROOT)}, check=False,
    )  # fmt: skip
    assert (ran.returncode, ran.stderr) == (0, "")
    assert "The cache holds" in ran.stdout


@pytest.mark.parametrize(("name", "status"), [("paper", 0), ("no_such_scenario", 1)])
def test_a_second_process_makes_the_planners_that_it_is_told(name, status):
    with planners_ahead([name], ["planner.margin=0.02"], None) as process:
        assert process.wait(900) == status


def test_a_second_process_ends_with_the_first_ones_work():
    with planners_ahead(["paper", "push"], [], None) as process:
        pass
    assert process.returncode == -signal.SIGKILL


def test_the_progress_bar_of_a_warmup_shows_the_step_and_the_kernels(monkeypatch):
    terminal = Console(file=StringIO(), force_terminal=True, width=120)
    monkeypatch.setattr("doorman.cli.terminal.display.Console", lambda **_: terminal)
    counts = iter(range(7, 1000))
    with warmup_progress(2, lambda: KernelCounts(next(counts), 0), shown=True) as on_step:
        on_step("paper: planner")
        on_step("paper: check")
    text = terminal.file.getvalue()
    for words in ("paper: planner", "paper: check", "compiling, once: 1 of at most", "0:00:00"):
        assert words in text


@pytest.mark.parametrize(("shown", "is_terminal"), [(False, True), (True, False)])
def test_there_is_no_progress_bar_for_programs(monkeypatch, shown, is_terminal):
    terminal = Console(file=StringIO(), force_terminal=is_terminal, width=100)
    monkeypatch.setattr("doorman.cli.terminal.display.Console", lambda **_: terminal)
    with warmup_progress(1, lambda: KernelCounts(0, 0), shown) as on_step:
        on_step("paper: planner")
    with flight_progress(4.0, shown) as on_progress:
        on_progress(4.0, 0.35)
    assert terminal.file.getvalue() == ""
