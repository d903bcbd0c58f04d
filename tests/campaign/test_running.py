"""Whole campaigns of short flights: the same rows however they are flown, whatever happens on the way."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import psutil
import pyarrow.parquet as parquet
import pytest
from distributed import Client, LocalCluster
from typer.testing import CliRunner

import doorman
from doorman.campaign import Campaign
from doorman.campaign.flights.cluster import connected
from doorman.campaign.flights.cluster import first_done as _done
from doorman.campaign.folder import claimed
from doorman.campaign.results import OF_THE_CLOCK
from doorman.campaign.running import durable_rows, run_campaign
from doorman.cli import app
from doorman.exceptions import DoormanError

MAIN = [sys.executable, "-c", "from doorman.cli import main; main()"]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(doorman.__file__).parent.parent)}


def timeless(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows without what the clock decides."""
    names = dict.fromkeys(name for row in rows for name in row if name not in OF_THE_CLOCK)
    return [{name: row.get(name) for name in names} for row in rows]


def test_every_run_has_a_row_and_the_table_holds_them(flown):
    out, rows = flown
    assert [row["run"] for row in rows] == list(range(5))
    assert parquet.read_table(out / "results.parquet").num_rows == 5
    assert timeless(durable_rows(out)) == timeless(rows)
    for row in rows:
        assert row["success"] is False and row["reason"]  # the flights are too short to open a door
        assert row["error"] is not None or abs(row["final_error_deg"] - 70.0) < 5.0


def listening() -> set[str]:
    """Addresses that this process listens on."""
    connections = psutil.Process().net_connections("inet")
    return {connection.laddr.ip for connection in connections if connection.status == psutil.CONN_LISTEN}


def test_a_local_cluster_listens_on_loopback_only_and_beside_another():
    with connected(2, None) as one, connected(1, None) as other:
        assert one.submit(abs, -1).result() == other.submit(abs, 1).result() == 1
        assert listening() == {"127.0.0.1"}


def test_a_run_that_raises_is_a_row_with_its_error(flown):
    _, rows = flown
    assert [row["run"] for row in rows if row["error"] is not None] == [1]
    assert rows[1]["outcome"] == "error"
    assert "ScenarioError" in rows[1]["error"] and "contact.distance_from_hinge" in rows[1]["error"]


def test_nothing_was_compiled_in_a_flight(flown):
    assert [row["kernels_compiled"] for row in flown[1]] == [0] * 5


def test_a_finished_campaign_flies_nothing_again(campaign, flown):
    out, _ = flown
    new: list[int] = []
    again = run_campaign(campaign, out, workers=1, on_row=lambda row, known, total: new.append(row["run"]))
    assert new == [] and again == durable_rows(out)
    assert run_campaign(campaign, out, runs=2, workers=1) == again[:2]


@pytest.mark.slow
def test_another_cluster_goes_on_with_a_larger_campaign_to_the_same_rows(campaign, flown, tmp_path):
    out, rows = flown
    shutil.copytree(out, tmp_path, dirs_exist_ok=True)
    for run in (3, 4):
        (tmp_path / "runs" / f"run-{run:07d}.parquet").unlink()
    seen: list[tuple[int, int, int]] = []
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address="127.0.0.1:0", memory_limit=None) as cluster:
        more = run_campaign(
            campaign, tmp_path, scheduler=cluster.scheduler_address,
            on_row=lambda row, known, total: seen.append((row["run"], known, total)),
        )  # fmt: skip
    assert sorted(run for run, *_ in seen) == [3, 4] and [counts for _, *counts in seen] == [[4, 5], [5, 5]]
    assert timeless(more) == timeless(rows)


def test_a_campaign_that_was_killed_goes_on_to_the_same_table(campaign, task, flown, tmp_path):
    command = [*MAIN, "campaign", str(task), "--workers", "1", "--out", str(tmp_path)]
    process = subprocess.Popen(command, env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 300.0
    while len(list(tmp_path.glob("runs/*.parquet"))) < 2:
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.01)
    processes = psutil.Process(process.pid).children(recursive=True)
    process.send_signal(signal.SIGKILL)
    process.wait()
    first = {path: path.stat().st_mtime_ns for path in tmp_path.glob("runs/*.parquet")}
    assert 2 <= len(first) < 5 and not (tmp_path / "results.parquet").exists()
    (tmp_path / "runs" / "run-0000004.unfinished").write_bytes(b"PAR1 half a part")
    rows = run_campaign(campaign, tmp_path, workers=1)
    assert timeless(rows) == timeless(flown[1])
    assert all(path.stat().st_mtime_ns == mtime for path, mtime in first.items())
    _, left = psutil.wait_procs(processes, timeout=60.0)
    assert processes and not left


def test_a_run_that_takes_too_long_is_given_up(task, tmp_path):
    hasty = Campaign(str(task), {"campaign.time_out": 1e-3})
    (row,) = run_campaign(hasty, tmp_path, runs=1, workers=1)
    assert row["error"] == row["reason"] == "timed out after 0.001 s of wall-clock time"
    assert (row["success"], row["outcome"]) == (False, "error")


def test_the_command_of_a_failure_flies_it_again_to_the_bit(flown, tmp_path):
    row = flown[1][2]
    words = shlex.split(row["command"])
    assert words[:2] == ["doorman", "open"] and words[3:5] == ["--seed", str(row["seed"])]
    outcome = CliRunner().invoke(app, [*words[1:], "--out", str(tmp_path), "--json"])
    assert outcome.exit_code == 1, outcome.output
    summary = json.loads((tmp_path / "summary.json").read_text())
    compared = [name for name in row if name.startswith("summary.") and name not in OF_THE_CLOCK]
    assert len(compared) >= 10
    for name in compared:
        found = summary
        for part in name.removeprefix("summary.").split("."):
            found = found[part]
        assert row[name] == (json.dumps(found) if isinstance(found, list) else found), name


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense://x"])
def test_a_cluster_that_is_not_there_is_an_error(campaign, tmp_path, monkeypatch, address):
    monkeypatch.setattr("doorman.campaign.flights.cluster._CONNECTION_TIME", 0.5)
    with pytest.raises(DoormanError) as caught:
        run_campaign(campaign, tmp_path, scheduler=address)
    assert caught.value.field == "--scheduler"


def test_a_cluster_whose_workers_are_gone_is_an_error(campaign, tmp_path, monkeypatch):
    monkeypatch.setattr("doorman.campaign.flights.cluster._LOOK", 0.05)
    monkeypatch.setattr("doorman.campaign.flights.cluster._WORKERLESS", 0.2)
    with LocalCluster(n_workers=0, dashboard_address="127.0.0.1:0", processes=False) as cluster:
        with pytest.raises(DoormanError, match="no worker for") as caught:
            run_campaign(campaign, tmp_path, scheduler=cluster.scheduler_address)
    assert caught.value.field == "--scheduler"


def test_a_flight_that_the_cluster_drops_is_an_error():
    with (
        LocalCluster(n_workers=0, dashboard_address="127.0.0.1:0", processes=False) as cluster,
        Client(cluster) as client,
    ):
        future = client.submit(abs, -1)
        threading.Timer(0.5, client.cancel, ([future],)).start()
        with pytest.raises(DoormanError, match="has dropped a flight") as caught:
            _done(client, [future])
    assert caught.value.field == "--scheduler"


def test_workers_of_a_local_cluster_are_not_given_up_for_silence():
    with connected(1, None) as client:
        assert client.cluster.scheduler.worker_ttl is None


def test_a_folder_belongs_to_one_campaign(task, flown):
    out, _ = flown
    with pytest.raises(DoormanError, match="another campaign") as caught:
        run_campaign(Campaign(str(task), {"campaign.seed": 3, "contact.height": 0.85}), out)
    assert "scenario.campaign.seed, scenario.contact.height" in str(caught.value.given)


def test_more_runs_and_more_patience_are_the_same_campaign(task, tmp_path):
    for runs, time_out in ((2, 60.0), (5, 60.0), (5, 600.0)):
        with claimed(tmp_path, Campaign(str(task), {"campaign.runs": runs, "campaign.time_out": time_out})):
            pass


def test_one_campaign_at_a_time_writes_to_a_folder(campaign, tmp_path):
    with claimed(tmp_path, campaign) as parts:
        with pytest.raises(DoormanError, match="another process"), claimed(tmp_path, campaign):
            pass
        assert parts.is_dir()
