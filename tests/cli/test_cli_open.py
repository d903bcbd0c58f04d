"""`doorman open`: exit status, progress, Ctrl-C, and what a run leaves behind."""

from __future__ import annotations

import json
import re
import signal
import time
import tomllib
import urllib.request
from io import StringIO
from pathlib import Path

import pytest
from at_the_door import AT_THE_DOOR
from command_line import assert_bad_input, run, start
from rich.console import Console
from typer.testing import Result

from doorman.cli.simulated.open_door import RUN_FILES
from doorman.cli.terminal.display import flight_progress
from doorman.compilation import KernelCounts
from doorman.model import Model
from doorman.postures.proposal import PAPER_POSTURES
from doorman.recording import Recording
from doorman.scenario import Scenario
from doorman.visualization import PicturesMissing


@pytest.fixture(scope="module")
def flight(tmp_path_factory: pytest.TempPathFactory) -> tuple[Result, Path]:
    """The paper's task, flown once for all tests below."""
    folder = tmp_path_factory.mktemp("flight")
    return run("open", "paper", "--out", str(folder / "run"), "--seed", "5"), folder / "run"


def test_the_door_opens_and_the_status_is_0(flight):
    result, folder = flight
    assert result.exit_code == 0, result.output
    assert "The door was opened" in result.stdout
    assert "door's angle at the end" in result.stdout
    assert "postures" not in result.stdout, "the paper's go without saying"
    assert str(folder) in result.stdout.replace("\n", "")
    assert result.stdout.splitlines()[-1] == f"Watch it again: doorman view {folder}"
    assert result.stderr == ""


def test_proposed_postures_are_told_and_kept_with_the_run(tmp_path):
    """In one line, before the flight; the run's own scenario flies them again."""
    given = ("--set", "goal.door_angle=0.785", "--duration", "0.1", "--json", "--out", str(tmp_path))
    result = run("open", "paper", *given)
    (line,) = [line for line in result.stderr.splitlines() if line.startswith("Proposed postures: ")]
    json.loads(result.stdout)
    model, again = Model(Scenario.load("paper", {"goal.door_angle": 0.785})), Scenario.load(tmp_path / "scenario.toml")
    assert f"goal.arm = {list(model.proposed['goal.arm'])}" in line and "start" not in line
    assert (again.goal.attitude, again.goal.arm) == (model.proposed["goal.attitude"], model.proposed["goal.arm"])
    assert (again.start.attitude, again.start.arm) == ((0.0, 0.0, 0.0), (0.0, 1.0, -0.6, -0.4))


def test_a_run_leaves_every_file(flight):
    _, folder = flight
    assert {path.name for path in folder.iterdir()} == set(RUN_FILES)
    for name in ("states", "constraints"):
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert (folder / f"{name}.pdf").read_bytes().startswith(b"%PDF")
    page = (folder / "replay.html").read_text(encoding="utf-8")
    assert "<html" in page and len(page) > 100_000


def test_the_summary_of_a_run_is_that_of_its_recording(flight):
    _, folder = flight
    summary = json.loads((folder / "summary.json").read_text())
    truth = Recording.load(folder / "recording.mcap")["truth"]
    assert summary["opened"] is True
    assert summary["final_door_angle_deg"] == pytest.approx(truth["door_angle"][-1] * 57.29577951308232, abs=1e-9)
    assert summary["collisions"] == 0
    assert summary["min_clearance_m"] > 0.0


def test_the_scenario_of_a_run_is_the_one_that_was_flown(flight):
    _, folder = flight
    tables = tomllib.loads((folder / "scenario.toml").read_text(encoding="utf-8"))
    assert tables["contact"] == {
        "distance_from_hinge": 0.7, "friction": 0.6, "height": 0.8,
        "kind": "grip",
    }  # fmt: skip
    flown = Scenario.load(folder / "scenario.toml")
    assert flown.model_dump() == Scenario.load("paper", PAPER_POSTURES).model_dump()


def test_json_is_the_only_thing_on_stdout_and_a_shut_door_is_status_1(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run("open", "--duration", "0.3", "--set", "planner.margin=0.03", "--json")
    assert result.exit_code == 1
    summary = json.loads(result.stdout)
    assert summary["opened"] is False
    assert summary["time_to_open_s"] is None
    assert result.stderr.count("\n") == 1 and "not opened" in result.stderr
    (folder,) = (tmp_path / "runs").iterdir()
    assert folder.name.startswith("paper-")
    assert json.loads((folder / "summary.json").read_text()) == summary
    assert Scenario.load(folder / "scenario.toml").planner.margin == 0.03


def test_the_seed_decides_and_pictures_that_do_not_fit_on_the_disk_change_nothing(tmp_path, monkeypatch):
    def full_disk(*_: object) -> None:
        raise PicturesMissing("missing: states.png: No space left on device", file=tmp_path)

    monkeypatch.setattr("doorman.visualization.write_pictures", full_disk)
    at_the_door = [word for key, value in AT_THE_DOOR.items() for word in ("--set", f"{key}={value}")]
    results = [
        run("open", "--duration", "0.2", "--seed", seed, "--json", "--out", str(tmp_path), *at_the_door)
        for seed in ("1", "1", "2")
    ]
    for result in results:  # what could not be drawn costs neither status nor summary
        assert result.exit_code == 1 and "missing: states.png: No space left on device" in result.stderr
    summaries = [json.loads(result.stdout) for result in results]
    assert Recording.load(tmp_path).complete and json.loads((tmp_path / "summary.json").read_text()) == summaries[-1]
    angles = [summary["final_door_angle_deg"] for summary in summaries]
    assert angles[0] == angles[1] != angles[2]


def test_the_progress_bar_shows_the_door_and_the_time_left(monkeypatch):
    terminal = Console(file=StringIO(), force_terminal=True, width=100)
    monkeypatch.setattr("doorman.cli.terminal.display.Console", lambda **_: terminal)
    compiled = iter(range(1000))
    monkeypatch.setattr("doorman.cli.terminal.display.kernel_counts", lambda: KernelCounts(next(compiled), 0))
    with flight_progress(4.0, shown=True) as on_progress:
        on_progress(1.0, 1.0)
        on_progress(4.0, 0.35)
    text = terminal.file.getvalue()
    for words in ("Preparing", "Flying", "1.0 s", "door at 57°", "4.0 s", "door at 20°", "left"):
        assert words in text
    done, most = map(int, re.search(r"(\d+) of at most (\d+) kernels", text).groups())
    assert 0 < done < most
    assert "kernels" not in text[text.index("Flying") :], "nothing compiles in flight"


def test_ctrl_c_keeps_what_was_flown(tmp_path):
    process = start("open", "--out", "run", "--duration", "600", "--realtime", folder=tmp_path)
    recording = tmp_path / "run" / "recording.mcap"
    deadline = time.monotonic() + 120.0
    while not (recording.is_file() and recording.stat().st_size > 300_000):
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.05)
    second = run("open", "--duration", "0.1", "--set", "contact.height=0.9", "--out", str(tmp_path / "run"))
    assert_bad_input(second, "another run writes to this folder", str(tmp_path / "run"))
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 1, err
    assert err == ""
    assert "Interrupted after" in out
    assert {path.name for path in (tmp_path / "run").iterdir()} == set(RUN_FILES)
    loaded = Recording.load(recording)
    assert loaded.complete
    assert loaded["truth"].time[-1] > 0.1
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["opened"] is False
    assert Scenario.load(tmp_path / "run" / "scenario.toml").contact.height == 0.8


def test_the_flight_is_served_while_it_is_flown(tmp_path):
    settings = [word for key, value in AT_THE_DOOR.items() for word in ("--set", f"{key}={value}")]
    process = start("open", "--out", "run", "--duration", "1", "--view", "--json", *settings, folder=tmp_path)
    try:
        address = re.search(r"http://127\.0\.0\.1:\d+/", process.stderr.readline())[0]
        with urllib.request.urlopen(f"{address}frames", timeout=300) as answer:
            sent = answer.read().decode()
        assert sent.count('"poses":') >= 29 and "event: end" in sent
        assert json.loads(process.communicate(timeout=300)[0])["duration_s"] == pytest.approx(1.0, abs=0.02)
    finally:
        process.kill()
        process.communicate()
