"""The two examples are one program with two backends; the vehicle's takes off and lands by itself."""

from __future__ import annotations

import difflib
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from flight_rig import FlightRig, until

from doorman.exceptions import BackendError
from doorman.flight import Check, End, FlyingBackend, Verdict
from doorman.hardware.interface import Command
from doorman.hardware.safety import Action, Fault

ROOT = Path(__file__).parents[2]
SIMULATED, FLOWN = (ROOT / "examples" / f"{name}_the_door.py" for name in ("open", "fly"))


def test_examples_differ_in_the_backend_only():
    lines = [path.read_text(encoding="utf-8").split('"""', 2)[2].splitlines() for path in (SIMULATED, FLOWN)]
    changed = [line for line in difflib.ndiff(*lines) if line[0] in "+-"]
    code = [line[2:] for line in changed if not line[2:].startswith(("import ", "from ", "recorder = "))]
    assert [line.partition("=")[0].strip() for line in code] == ["backend", "backend"]


def test_the_example_says_which_link_is_missing():
    ran = subprocess.run(
        [sys.executable, str(FLOWN), "udp:1", "/dev/no-such-port"], cwd=ROOT, capture_output=True, text=True, check=False,
        timeout=400, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert ran.returncode == 1
    assert "not flown to its end" in ran.stderr
    assert "/dev/no-such-port" in ran.stderr


def test_the_backend_takes_off_and_lands(rig: FlightRig, monkeypatch: pytest.MonkeyPatch):
    rig.links.stop()
    words = rig.far.arguments
    backend = FlyingBackend(rig.model, words[1], words[3], words[5])
    try:
        with pytest.raises(SystemExit), backend:  # a program that is asked to end does not leave it in the air
            signal.raise_signal(signal.SIGTERM)
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
        until(lambda: rig.snapshot.on_ground and not rig.snapshot.motors, "landed")
        with backend:
            assert rig.snapshot.truth.position == pytest.approx(rig.places.hover, abs=0.2)
            measurement = backend.read()
            backend.command(Command(rig.model.hover_input[0], measurement.attitude * 0.0, measurement.arm_rates * 0.0))
        until(lambda: rig.snapshot.on_ground and not rig.snapshot.motors, "landed")
        with pytest.raises(BackendError, match="not open"):
            backend.read()
        with pytest.raises(KeyboardInterrupt), backend:

            def interrupted() -> None:
                raise KeyboardInterrupt

            monkeypatch.setattr(backend.flight.way_back, "fly", interrupted)
        until(lambda: rig.snapshot.on_ground and not rig.snapshot.motors, "landed, by Ctrl-C on the way back")
        assert backend.flight.supervisor.action is Action.LAND
    finally:
        backend.stop()
        rig.links.open()


def test_what_is_found_before_and_in_a_flight_is_told(rig: FlightRig):
    rig.links.stop()
    words, said, shown, asked = rig.far.arguments, [], [], []

    def confirm(checks: list[Check]) -> bool:
        shown.append(checks)
        return len(shown) > 1

    backend = FlyingBackend(rig.model, words[1], words[3], words[5], say=said.append, confirm=confirm)
    rig.far.call("set_register", 2, "present temperature", 65)
    try:
        with pytest.raises(BackendError, match="not confirmed"):
            backend.open()
        assert backend.end is End.NOT_FLOWN and rig.snapshot.on_ground and not rig.snapshot.motors
        warned = [check.name for check in shown[0] if check.verdict is Verdict.WARNING]
        assert "servos' temperature" in warned
        assert [line.partition(":")[0] for line in said[: len(warned)]] == warned
        rig.far.call("set_register", 2, "present temperature", 30)
        backend.watch_mission(asked.append)
        with backend:
            backend.flight.supervisor.report(Fault.BATTERY_LOW)
            assert asked == [Fault.BATTERY_LOW.value], "the mission's own controller may fly back"
            assert backend.flight.supervisor.action is Action.ABORT
            with pytest.raises(BackendError, match="flies already"):
                backend.open()
            assert rig.snapshot.motors and not rig.snapshot.on_ground
        assert backend.end is End.LANDED and "land" in said
        backend.open()  # another flight, which knows nothing of the last one
        assert not backend.flight.supervisor.findings
        rig.far.call("rig.autopilot.kill_switch")
        with pytest.raises(BackendError, match="motors stopped in the air"):
            backend.stop()
        assert backend.end is End.FALLEN
    finally:
        backend.stop()
        rig.links.open()
