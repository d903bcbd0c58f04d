"""What machine, software or user's folder do to a campaign is no flight: tried again, listed apart, and never left running."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import psutil
import pytest
from distributed import LocalCluster
from typer.testing import CliRunner

import doorman
from doorman.campaign import Campaign, running
from doorman.campaign.flights import flight_process, flight_program
from doorman.campaign.flights.orders import digests, order_of, packed, software
from doorman.campaign.folder import read_not_flown
from doorman.campaign.results import read_parts
from doorman.cli import app
from doorman.exceptions import DoormanError
from doorman.flown import carried_files

ROOT = Path(doorman.__file__).parents[1]


def test_files_in_the_users_folder_are_not_imported(task: Path, tmp_path: Path, monkeypatch) -> None:
    for name in ("random", "doorman", "numpy"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('not this one')\n")
    monkeypatch.chdir(tmp_path)
    (row,) = running.run_campaign(Campaign(str(task)), tmp_path / "out", runs=1, workers=1)
    assert row["error"] is None and row["outcome"] != "error"


Answers = Callable[[dict[str, Any]], dict[str, Any]]


def flown_by(monkeypatch, answers: Answers) -> list[int]:
    """Let a function answer orders instead of flight processes; the runs that were ordered, in their order."""
    ordered: list[int] = []

    def fly(self: object, order: dict[str, Any], files: object, time_out: float) -> dict[str, Any]:
        ordered.append(order["run"])
        return answers(order)

    monkeypatch.setattr(flight_process.FlightProcess, "fly", fly)
    return ordered


def test_what_is_lost_is_tried_again_and_never_a_row(task: Path, tmp_path: Path, monkeypatch) -> None:
    def answers(order: dict[str, Any]) -> dict[str, Any]:
        if order["run"] == 2 or (order["run"] == 0 and ordered.count(0) == 1):
            return flight_process.lost("the disk is full")
        return flight_process.failed("the door fell out")

    ordered = flown_by(monkeypatch, answers)
    rows = running.run_campaign(Campaign(str(task)), tmp_path, workers=1)
    assert [row["run"] for row in rows] == [0, 1, 3, 4]
    assert (ordered.count(0), ordered.count(1), ordered.count(2)) == (2, 1, 3)
    assert read_not_flown(tmp_path) == {2: "the disk is full"}
    ordered.clear()
    flown_by(monkeypatch, lambda order: flight_process.failed("flown"))
    assert len(running.run_campaign(Campaign(str(task)), tmp_path, workers=1)) == 5
    assert read_not_flown(tmp_path) == {}


def test_missing_runs_are_a_failure_of_the_command(task: Path, tmp_path: Path, monkeypatch) -> None:
    flown_by(
        monkeypatch, lambda order: flight_process.lost("gone") if order["run"] == 1 else flight_process.failed("flown")
    )
    done = CliRunner().invoke(app, ["campaign", str(task), "--workers", "1", "--out", str(tmp_path)])
    assert done.exit_code == 1 and "Not flown: 1 of 5 runs" in done.output
    assert "## Not flown" in (tmp_path / "report.md").read_text()
    assert json.loads((tmp_path / "report.json").read_text())["not_flown"] == {"1": "gone"}
    flown_by(monkeypatch, lambda order: flight_process.failed("flown"))
    done = CliRunner().invoke(app, ["campaign", str(task), "--workers", "1", "--out", str(tmp_path)])
    assert done.exit_code == 0 and "Not flown" not in done.output


def test_a_cluster_that_flies_nothing_ends_the_campaign(task: Path, tmp_path: Path, monkeypatch) -> None:
    ordered = flown_by(monkeypatch, lambda order: flight_process.lost("no memory"))
    with pytest.raises(DoormanError, match="20 flights in a row .* no memory"):
        running.run_campaign(Campaign(str(task)), tmp_path, runs=100, workers=1)
    assert len(ordered) < 30


def order(task: Path) -> tuple[dict[str, Any], dict[str, str]]:
    flight = Campaign(str(task)).flight(0)
    files = carried_files(flight.scenario)
    return order_of(flight, files), packed(files)


def test_an_order_for_other_software_or_with_other_files_is_refused(task: Path, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    given, contents = order(task)
    other_door = contents | packed({"door.urdf": b"<robot/>"})
    for change, files, words in (
        ({"software": software() | {"numba": "0.1"}}, contents, "instead of 0.1"),
        ({}, other_door, "other files"),
    ):
        answer = flight_program.answer({**given, **change, "prepare": True, "contents": files})
        assert answer["lost"] and words in answer["error"]


@pytest.mark.parametrize("fault", [MemoryError("none"), OSError(28, "No space left on device"), ImportError("no")])
def test_faults_of_the_machine_are_not_the_flights(task: Path, tmp_path: Path, monkeypatch, fault: Exception) -> None:
    monkeypatch.chdir(tmp_path)
    given, contents = order(task)

    def broken(*_: object, **__: object) -> None:
        raise fault

    monkeypatch.setattr(flight_program, "prepare", broken)
    assert flight_program.answer(given | {"prepare": True, "contents": contents})["lost"]
    monkeypatch.setattr(flight_program, "simulate", lambda *_, **__: 1 / 0)
    assert not flight_program.answer(given)["lost"]


def test_a_campaign_flies_with_the_clients_own_files(task: Path, tmp_path: Path) -> None:
    """The worker gets the URDF, not its path."""
    door = (ROOT / "urdf" / "hinged_door.urdf").read_text()
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "mydoor.urdf").write_text(door)
    text = task.read_text() + '\n[door]\nurdf = "mydoor.urdf"\n'
    (tmp_path / "mine" / "task.toml").write_text(text)
    flight = Campaign(str(tmp_path / "mine" / "task.toml")).flight(0)
    files = carried_files(flight.scenario)
    given = order_of(flight, files)
    assert given["files"] == digests(files)
    (tmp_path / "mine" / "mydoor.urdf").unlink()
    (tmp_path / "worker").mkdir()
    from doorman.campaign.flights.orders import unpacked

    scenario = unpacked(given, packed(files), tmp_path / "worker")
    assert scenario.door_urdf.read_bytes() == door.encode() and scenario.door_urdf.parent == tmp_path / "worker"


def test_a_damaged_row_is_flown_again(task: Path, tmp_path: Path, monkeypatch, caplog) -> None:
    flown_by(monkeypatch, lambda order: flight_process.failed("flown"))
    campaign = Campaign(str(task))
    running.run_campaign(campaign, tmp_path, runs=3, workers=1)
    (tmp_path / "runs" / "run-0000001.parquet").write_bytes(b"PAR1 not really PAR1")
    ordered = flown_by(monkeypatch, lambda order: flight_process.failed("flown again"))
    rows = running.run_campaign(campaign, tmp_path, runs=3, workers=1)
    assert ordered == [1] and [row["error"] for row in rows] == ["flown", "flown again", "flown"]
    assert sum("damaged" in record.message for record in caplog.records) == 1


def test_parts_and_identity_are_synced(task: Path, tmp_path: Path, monkeypatch) -> None:
    flown_by(monkeypatch, lambda order: flight_process.failed("flown"))
    synced: list[int] = []
    sync = os.fsync

    def noted(handle: int) -> None:
        synced.append(os.fstat(handle).st_ino)
        sync(handle)

    monkeypatch.setattr(os, "fsync", noted)
    running.run_campaign(Campaign(str(task)), tmp_path, runs=2, workers=1)
    files = [tmp_path / "campaign.json", *sorted((tmp_path / "runs").glob("*.parquet")), tmp_path / "results.parquet"]
    assert len(files) == 4 and {path.stat().st_ino for path in files} <= set(synced)
    assert set(read_parts(tmp_path / "runs")) == {0, 1}


def test_a_damaged_identity_is_a_sentence(task: Path, tmp_path: Path) -> None:
    (tmp_path / "campaign.json").write_text("")
    with pytest.raises(DoormanError, match="damaged"):
        running.run_campaign(Campaign(str(task)), tmp_path, runs=1, workers=1)


def test_a_million_runs_begin_at_once(task: Path, tmp_path: Path, monkeypatch) -> None:
    """Draws are made and ordered as they are flown."""

    class Enough(Exception):
        pass

    begun, process = time.monotonic(), psutil.Process()
    before = process.memory_info().rss

    def stop(row: object, known: int, total: int) -> None:
        assert total == 1_000_000 and time.monotonic() - begun < 60.0
        raise Enough

    ordered = flown_by(monkeypatch, lambda order: flight_process.failed("flown"))
    with pytest.raises(Enough):
        running.run_campaign(Campaign(str(task)), tmp_path, runs=1_000_000, workers=2, on_row=stop)
    assert len(ordered) < 100
    assert process.memory_info().rss - before < 400e6


def test_a_draw_that_is_out_of_range_is_a_row(tmp_path: Path, monkeypatch) -> None:
    flown_by(monkeypatch, lambda order: flight_process.failed("flown"))
    path = tmp_path / "task.toml"
    path.write_text("[campaign]\nruns = 40\n[campaign.vary]\nsimulation.door_mass = { mean = 1.0, std = 2.0 }\n")
    rows = running.run_campaign(Campaign(str(path)), tmp_path / "out", workers=1)
    refused = [row for row in rows if "ScenarioError" in row["error"]]
    assert len(rows) == 40 and 0 < len(refused) < 40 and "simulation.door_mass" in refused[0]["error"]


CLIENT = """
import sys, time
from pathlib import Path
from doorman.campaign import Campaign
from doorman.campaign.running import run_campaign
run_campaign(Campaign(sys.argv[1], {"campaign.duration": 20.0}), Path(sys.argv[2]), runs=30, scheduler=sys.argv[3])
"""


def flight_processes_of(process: psutil.Process) -> list[psutil.Process]:
    found = []
    for child in process.children(recursive=True):
        try:
            if "doorman.campaign.flights.flight_program" in child.cmdline():
                found.append(child)
        except psutil.Error:
            continue
    return found


def test_a_killed_client_leaves_no_process_on_the_cluster(task: Path, tmp_path: Path) -> None:
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address="127.0.0.1:0", memory_limit=None) as cluster:
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        command = [sys.executable, "-c", CLIENT, str(task), str(tmp_path / "out"), cluster.scheduler_address]
        client = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + 120.0
        while not (processes := flight_processes_of(psutil.Process())):
            assert client.poll() is None and time.monotonic() < deadline
            time.sleep(0.05)
        client.send_signal(signal.SIGKILL)
        client.wait()
        _, left = psutil.wait_procs(processes, timeout=10.0)
        assert not left
