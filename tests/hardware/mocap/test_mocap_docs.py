"""What docs/hardware/mocap.md says: its example runs, its rows are tests, its names exist, its numbers are those of the code."""

from __future__ import annotations

import ast
import re
from dataclasses import fields
from pathlib import Path

import pytest
from mocap_rig import free_port, swaying
from mocap_table import PAGE, table

from doorman.hardware.mocap import MocapConfig, MocapFault, MocapStatistics, PoseQuality, PoseSample
from doorman.hardware.mocap.datagrams.clock import _DRIFT, _DRIFTED
from doorman.hardware.mocap.datagrams.rate import _EXACT_BIN, _LEARNING_BINS, _LEARNING_LAG, _STEADY, FINE
from doorman.hardware.mocap.datagrams.sequence import FORGIVEN, NEW_RUN
from doorman.hardware.mocap.worker import REOPEN_INTERVAL
from doorman.rig.emulators.mocap.emulator import MocapEmulator, StreamFaults, TrackerSetup

HERE = Path(__file__).parent


def names_of_tests() -> set[str]:
    return {
        node.name
        for path in HERE.rglob("test_*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    }


def test_every_row_of_the_fault_table_is_a_test():
    rows = table("Faults")
    assert len(rows) >= 25
    assert {re.fullmatch(r"`(\w+)`", row[-1])[1] for row in rows} <= names_of_tests()
    assert all(len(row) == 6 and all(row) for row in rows)


def test_every_fault_is_in_the_table():
    told = {name for row in table("Faults") for name in re.findall(r"\b[A-Z]{4,}\b", row[1])}
    assert told == {fault.name for fault in MocapFault}


def test_every_quality_is_in_the_table():
    assert [row[0].strip("`") for row in table("Samples")] == [quality.name for quality in PoseQuality]


def test_names_exist():
    known = {field.name for kind in (MocapConfig, MocapStatistics, PoseSample, TrackerSetup) for field in fields(kind)}
    known |= {
        "MocapReceiver",
        "MocapEvent",
        "MocapFault",
        "TrackerSetup",
        "usable",
        "open",
        "source",
        "sources",
        "motioncapture",
        "mocap",
        "connection",
        "PoseSource",
        "PoseSender",
        "NatNetEmulator",
        "read",
        "stop",
        "taken",
        "CLOCK_MONOTONIC_RAW",
    }
    known |= {one.name for kind in (PoseQuality, MocapFault) for one in kind}
    used = set(re.findall(r"`([A-Za-z_]+)`", PAGE))
    assert {name for name in used if not name.startswith("test_")} <= known


@pytest.mark.parametrize("name", ["silent", "frozen", "zeroed", "absent", "wrong_name", "jump", "outliers", "delay"])
def test_faults_of_the_emulator_exist(name):
    assert name in {field.name for field in fields(StreamFaults)}


def test_figures_are_those_of_the_code():
    config = MocapConfig("quad")
    limit, lag = config.prediction_limit, config.velocity_window / 2
    gate = config.position_slack + config.max_acceleration * config.period * (config.period / 2 + lag)
    assert [row[1] for row in table("Figures")] == [
        f"{1e3 * config.stale_after:g} ms", f"{1e3 * limit:g} ms", f"{config.hold:g} s", f"{1e3 * config.latency:g} ms",
        f"{1e3 * lag:g} ms", f"{2e3 * limit * (limit / 2 + lag):.0f} mm", f"{1e3 * gate:.0f} mm", f"{100 * FINE:g} %",
        f"{_EXACT_BIN * _LEARNING_BINS:g} s", f"{1e3 * _STEADY * _LEARNING_LAG * _EXACT_BIN:g} ms", f"{1e3 * _DRIFT:g} ms",
        f"{1e3 * _DRIFTED:g} ms", f"{900e3 * _DRIFT:g} ms",
    ]  # fmt: skip


def test_numbers_of_the_fault_table_are_those_of_the_code():
    told = " ".join(cell for row in table("Faults") for cell in row)
    assert f"{NEW_RUN} frames at the right pace" in told
    assert f"if {FORGIVEN:g} s behind or more" in told
    assert f"every {1e3 * REOPEN_INTERVAL:g} ms" in told
    assert f"measured {MocapConfig('quad').acquire_frames} frames after" in told


def test_the_example_runs(capsys):
    code = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)[1]
    port = free_port()
    code = code.replace("udp:192.168.10.7:51001", f"udp:{port}")
    setup = TrackerSetup("hexarotor", object_position=(0.0, 0.0, 0.06))
    with MocapEmulator(swaying, setup, ("127.0.0.1", port)):
        exec(compile(code, "docs/hardware/mocap.md", "exec"), {})
    assert "mocap: object acquired" in capsys.readouterr().out
