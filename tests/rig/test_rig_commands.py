"""`doorman rig` and `doorman fly` as commands: the whole mission over real links, a dry run, and input that cannot be used."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path

import numpy as np
import pytest
from flight_rig import free_port
from pymavlink.dialects.v20 import common as mavlink
from typer.testing import CliRunner, Result

from doorman.cli import app
from doorman.flight import Verdict
from doorman.hardware.scheduling import real_time
from doorman.model import Model
from doorman.recording import Recording
from doorman.rig import Rig, RigSetup
from doorman.rig.witness import together
from doorman.scenario import Scenario

ROOT = Path(__file__).parents[2]
COMMAND = [sys.executable, "-c", "from doorman.cli import main; main()"]


ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}


def run(*arguments: str, answer: str | None = None) -> Result:
    return CliRunner().invoke(app, list(arguments), input=answer, env={"COLUMNS": "200", "TERM": "dumb"})


def ran(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """A command in a process of its own, to its end."""
    return subprocess.run(
        [*COMMAND, *arguments], cwd=folder, text=True, capture_output=True, check=False, timeout=400, env=ENVIRONMENT
    )


def begun(folder: Path, *arguments: str) -> subprocess.Popen[str]:
    """A command in a process of its own."""
    return subprocess.Popen([*COMMAND, *arguments], cwd=folder, text=True, stdout=subprocess.PIPE, env=ENVIRONMENT)


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Rig]:
    """A rig in this process."""
    setup = RigSetup(pixhawk_port=free_port(), mocap_port=free_port(), folder=tmp_path)
    with real_time(), Rig(Model(Scenario.load("paper")), setup) as rig:
        yield rig


@pytest.mark.parametrize("scenario", ["paper", "push"])
def test_the_door_is_opened_over_real_links(tmp_path, scenario):
    flown = ran(tmp_path, "rig", scenario, "--fly", "--out", str(tmp_path / "truth.mcap"))
    assert flown.returncode == 0, flown.stdout + flown.stderr
    assert "The door was opened" in flown.stdout
    assert "landed and disarmed" in flown.stdout
    truth, flight = Recording.load(tmp_path / "truth.mcap"), Recording.load(tmp_path / "flight.mcap")
    assert not truth["truth"]["collisions"].any()
    assert truth["truth"]["position"][-1, 2] < 0.3, "it has landed"
    assert {"event", "epoch", "timing", "measurement", "plan"} <= set(flight)
    assert flight["timing"]["longest_setpoint_gap"][-1] < 0.05
    both = together(truth, flight)
    error = both["truth"]["position"] - both["estimate"]["position"]
    assert np.abs(error).max() < 0.05, "the two recordings are on one clock"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a disk that is full")
def test_a_full_disk_loses_the_recording_and_not_the_flight(served):
    result = run("fly", "paper", *served.arguments, "--yes", "--json", "--duration", "2", "--out", "/dev/full")
    told = json.loads(result.stdout)
    assert told["end"] == "landed and disarmed", result.output
    assert "No space left" in told["unwritten"]
    assert "The recording is not whole" in result.stderr
    assert result.exit_code == 0, "the flight itself went as asked"


def test_dry_run_sends_nothing(served, tmp_path):
    out = tmp_path / "none.mcap"
    result = run("fly", "paper", *served.arguments, "--dry-run", "--yes", "--json", "--out", str(out))
    assert result.exit_code == 0, result.output
    assert "Nothing was sent" in result.stderr
    found = json.loads(result.stdout)
    assert found["ready"] is True and found["completed"] is False
    assert {one["verdict"] for one in found["checklist"]} <= {verdict.value for verdict in Verdict}
    heard = served.autopilot.receiver.received
    assert not sum(heard.values()), heard
    assert not any(served.servos.servo(index).memory.get("torque enable") for index in range(1, 6))
    assert not out.exists()


def test_without_an_answer_the_vehicle_is_not_flown(served):
    result = run("fly", "paper", *served.arguments, answer="n\n")
    assert result.exit_code == 1, result.output
    assert "Not flown" in result.output
    assert not served.autopilot.brain.armed


def test_settings_of_servos_are_changed_on_request_only(served):
    memory = served.servos.servo(2).memory
    memory.set("return delay time", 200)
    refused = run("fly", "paper", *served.arguments, "--yes")
    assert refused.exit_code == 2 and "return delay time" in refused.stderr and "--write-eeprom" in refused.stderr
    assert memory.get("return delay time") == 200
    result = run("fly", "paper", *served.arguments, "--write-eeprom", answer="n\n")
    assert result.exit_code == 1, result.output
    assert memory.get("return delay time") == 0


def test_parameters_are_written_on_request_and_then_nothing_is_flown(served):
    parameters = served.autopilot.parameters
    parameters["COM_OBL_RC_ACT"], parameters["COM_OF_LOSS_T"] = 0, 5.0
    result = run("fly", "paper", *served.arguments, "--write-parameters", "--yes", "--json")
    assert result.exit_code == 1, result.output
    found = json.loads(result.stdout)
    assert sorted(found["written"]) == ["COM_OBL_RC_ACT", "COM_OF_LOSS_T"]
    assert "Reboot the autopilot" in found["message"]
    assert parameters["COM_OBL_RC_ACT"] == 4 and parameters["COM_OF_LOSS_T"] == pytest.approx(0.2)
    assert not served.autopilot.brain.armed


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["fly", "paper", "--pixhawk", "carrier pigeon", "--servos", "/dev/null"], ["connection", "carrier pigeon"]),
        (["fly", "paper", "--pixhawk", "udp:1", "--servos", "x", "--servo-ids", "1,two"], ["--servo-ids", "1,two"]),
        (["rig", "paper", "--pixhawk-port", "70000"], ["pixhawk_port", "70000"]),
        (["rig", "no such"], ["no such scenario"]),
    ],
)
def test_bad_input_is_one_line(arguments, words):
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    assert result.stderr.startswith("doorman: error: ")
    for word in words:
        assert word in result.stderr


def test_links_that_are_not_there_are_named():
    result = run("fly", "paper", "--pixhawk", f"udp:{free_port()}", "--servos", "/dev/no-such-port")
    assert result.exit_code == 2, result.output
    assert "/dev/no-such-port" in result.stderr


def test_the_rig_prints_how_to_fly_and_ends_by_ctrl_c(tmp_path):
    settings = ["--set", "contact.kind=push", "--set", "start.arm=[0, 1, -0.6, -0.4]"]
    with begun(tmp_path, "rig", "paper", "--pixhawk-port", str(free_port()), "--mocap-port", "0", *settings) as process:
        lines = [process.stdout.readline(), process.stdout.readline()]
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 0
    assert re.match(
        r"doorman fly paper --set contact.kind=push --set 'start.arm=\[0, 1, -0.6, -0.4\]' --pixhawk udp:\d+ --servos \S+\n",
        lines[1],
    ), lines


@pytest.mark.slow
@pytest.mark.parametrize("autopilot", ["px4", "ardupilot"])
def test_motors_whose_thrust_is_the_squared_signal_are_flown_by_the_slope_that_hover_measures(tmp_path, autopilot):
    folder = tmp_path / "flown"
    options = "--fly", "--autopilot", autopilot, "--motors", "quadratic", "--out", str(folder)
    flown = ran(tmp_path, "rig", "paper", *options)
    assert flown.returncode == 0, flown.stdout + flown.stderr
    assert ("THR_MDL_FAC is 0" in flown.stdout) is (autopilot == "px4"), "the checklist says so"
    assert f"Results: {folder}" in flown.stdout.splitlines()
    assert {one.name for one in folder.iterdir()} == {"truth.mcap", "flight.mcap"}
    hover = Recording.load(folder / "flight.mcap")["hover"]
    assert hover["slope"][-1] == pytest.approx(2.0 if autopilot == "px4" else 1.25, abs=0.15)


ENDS_WITHIN = 2.0
"""After Ctrl-C, as the manual says; what else runs on the machine counts, so it must be idle [s]."""


def call_as_px4(port: int) -> socket.socket:
    """PX4 that talks all the time, but answers no state."""
    deadline = time.monotonic() + 60.0
    while True:
        try:
            called = socket.create_connection(("127.0.0.1", port), 1.0)
            break
        except OSError:
            assert time.monotonic() < deadline
            time.sleep(0.2)
    beat = mavlink.MAVLink_heartbeat_message(2, 12, 0, 0, 0, 3).pack(mavlink.MAVLink(None, 1, 1))

    def chatter() -> None:
        with suppress(OSError):
            while True:
                called.sendall(beat)
                time.sleep(0.002)

    threading.Thread(target=chatter, daemon=True).start()
    return called


@pytest.mark.slow
@pytest.mark.parametrize("autopilot", ["px4", "ardupilot", "px4-sitl", "ardupilot-sitl"])
def test_ctrl_c_ends_the_rig_at_once_and_the_judge_has_seen_nothing(tmp_path, autopilot):
    port = free_port() if autopilot != "px4-sitl" else 14548
    ports = "--pixhawk-port", str(port), "--mocap-port", str(free_port())
    with begun(tmp_path, "rig", "paper", "--judge", "--autopilot", autopilot, *ports) as process, ExitStack() as stack:
        while "doorman fly" not in process.stdout.readline():
            assert process.poll() is None
        if autopilot == "px4-sitl":
            stack.enter_context(call_as_px4(4568))
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        assert process.wait(ENDS_WITHIN) == 1
        assert "Nothing was flown" in process.stdout.read()


@pytest.mark.slow
def test_the_judge_agrees_with_the_one_that_flies_too(tmp_path):
    """Another process flies against a rig that judges; both say the same of the same truth."""
    ports = "--pixhawk-port", str(free_port()), "--mocap-port", str(free_port())
    with begun(tmp_path, "rig", "paper", "--judge", "--json", *ports) as process:
        command = shlex.split(json.loads(process.stdout.readline())["command"])
        flown = ran(tmp_path, *command[1:], "--yes", "--json", "--out", str(tmp_path / "flight.mcap"))
        process.send_signal(signal.SIGINT)
        figures, status = json.loads(process.stdout.readline()), process.wait(30)
    assert flown.returncode == 0, flown.stderr
    assert json.loads(flown.stdout)["seen"] == ""
    assert status == 0 and figures["outcome"] == "completed" and figures["landed"] and not figures["touched"], figures
    assert abs(figures["final_error"]) < 2.0 and figures["max_push_force_n"] > 0.0
