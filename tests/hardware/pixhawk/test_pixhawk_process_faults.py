"""The end of this process, and what the autopilot does then; the table in docs/hardware/pixhawk.md names these tests."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap

import numpy as np
from pixhawk_rig import landed, wait_until

from doorman.clocks import REAL_TIME
from doorman.rig.emulators.autopilot.control import Task

FLYER = """
    import sys, time
    import numpy as np
    from doorman.hardware.pixhawk import *
    pilot = Autopilot(PixhawkConfig(f"udp:{sys.argv[1]}", thrust_curve=ThrustCurve(0.4, 29.43), climb_rate=2.0))
    pilot.open()
    while pilot.state().status is not SampleStatus.FRESH:
        time.sleep(0.01)
    for outcome in (pilot.engage(), pilot.arm(), pilot.take_off(0.3)):
        assert outcome.done, outcome
    while True:
        pilot.setpoint(AttitudeSetpoint(29.43, np.zeros(3)))
        time.sleep(0.01)
"""


def test_process_killed(rigs):
    """SIGKILL: nothing of ours can act, so the autopilot must."""
    rig = rigs("px4", clock=REAL_TIME)
    rig.emulator.open()
    script = [sys.executable, "-c", textwrap.dedent(FLYER), str(rig.port)]
    with subprocess.Popen(script, stderr=subprocess.PIPE) as process:
        try:
            flying = wait_until(
                lambda: rig.emulator.brain.demand.task is Task.ATTITUDE or process.poll(), 30.0, REAL_TIME
            )
            assert flying and process.poll() is None, process.stderr.read() if process.stderr else None
        finally:
            os.kill(process.pid, signal.SIGKILL)
    assert landed(rig)
    assert rig.emulator.brain.is_in("land")


def test_ground_station_lost(rigs):
    """ArduPilot holds a position for ever without a stream: the loss of our heartbeat must make it land."""
    rig = rigs("ardupilot").fly()
    assert rig.pilot.hold().done
    rig.pilot._link.stop()
    assert landed(rig)


def test_stream_lost_with_default_parameters(rigs):
    """Why the parameters are checked: untouched, PX4 climbs to return."""
    rig = rigs("px4")
    rig.emulator.parameters["COM_OBL_RC_ACT"] = 0
    rig.fly()
    names = {finding.name for finding in rig.pilot.check_parameters()}
    assert "COM_OBL_RC_ACT" in names
    rig.emulator.brain.home = np.array([1.5, 0.0, 0.0])
    rig.pilot._link.stop()
    assert wait_until(lambda: rig.emulator.brain.is_in("return"))
    height = rig.emulator.truth.position[2]
    assert wait_until(lambda: rig.emulator.truth.position[2] > height + 0.2)
