"""The whole program is killed at random times of a mission: autopilot and servos end it by themselves.

One time; DOORMAN_FAULT_TIMES=20 in the environment for twenty.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from far_rig import FarRig
from flight_rig import AUTOPILOT, SCENARIO, free_port, until

from doorman.recording import Recording
from doorman.rig import RigSetup
from doorman.scenario import Scenario

ROOT = Path(__file__).parents[2]
TIMES = int(os.environ.get("DOORMAN_FAULT_TIMES", "1"))
LONGEST = {"paper": 25.0, "push": 34.0}[SCENARIO]
"""From arming to the end of the mission [s]."""
STOPPED = 1.0
"""Servos' watchdog and what a busy computer adds, after which the arm stands still and the gripper is open [s]."""


@pytest.mark.parametrize("repetition", range(TIMES))
def test_a_killed_program_leaves_the_rest_to_autopilot_and_servos(tmp_path: Path, repetition: int) -> None:
    when = float(np.random.default_rng(repetition).uniform(2.0, LONGEST))
    setup = RigSetup(AUTOPILOT, free_port(), free_port(), tmp_path)
    far = FarRig(Scenario.load(SCENARIO), setup)
    try:
        command = [sys.executable, "-c", "from doorman.cli import main; main()", "fly", SCENARIO, *far.arguments]
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        with subprocess.Popen([*command, "--yes", "--out", str(tmp_path / "flight.mcap")], env=environment) as process:
            try:
                until(lambda: far.get("rig.plant.snapshot").motors or process.poll() is not None, "armed")
                armed = time.monotonic()
                until(lambda: time.monotonic() - armed > when or process.poll() is not None, "the time of the fault")
                assert process.poll() is None, "the flight was over before"
            finally:
                process.send_signal(signal.SIGKILL)
        time.sleep(STOPPED)
        arm, open_again = far.get("rig.plant.snapshot").truth.arm_angles, not far.get("rig.plant._grip")
        time.sleep(0.5)
        moved = np.abs(far.get("rig.plant.snapshot").truth.arm_angles - arm).max()
        until(lambda: not far.get("rig.plant.snapshot").motors, "motors off")
        touched = sorted(set(far.get("collisions")))
        assert moved < 0.02, "the arm goes on"
        assert open_again, "the gripper holds on"
        assert not Recording.load(tmp_path / "flight.mcap").complete
        assert not touched, "the autopilot's way back"
    finally:
        far.stop()
