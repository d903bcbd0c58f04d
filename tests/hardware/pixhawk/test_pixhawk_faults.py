"""Every row of the fault table in docs/hardware/pixhawk.md, injected on real sockets; the table names these tests."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import textwrap
import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from pixhawk_rig import QUICK, WEIGHT, Rig, wait_until
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.exceptions import BackendError
from doorman.hardware.emulators.autopilot_control import Task
from doorman.hardware.emulators.autopilot_px4 import LAND, POSITION, RETURN
from doorman.hardware.pixhawk import (
    AttitudeSetpoint,
    Authority,
    Autopilot,
    EventKind,
    OutcomeStatus,
    PositionSetpoint,
    SampleStatus,
)

HOVER = AttitudeSetpoint(WEIGHT, np.zeros(3))


def landed(rig: Rig) -> bool:
    return wait_until(lambda: not rig.emulator.brain.armed and rig.emulator.truth.on_ground)


def fresh(rig: Rig) -> bool:
    return wait_until(lambda: rig.pilot.state().status is SampleStatus.FRESH)


# ---------------------------------------------------------------- the link


def test_messages_lost(rigs):
    rig = rigs("ardupilot")
    rig.emulator.parameters["FS_GCS_TIMEOUT"] = 10.0
    rig.emulator.start()
    rig.emulator.outgoing.loss = rig.emulator.incoming.loss = 0.2
    rig.pilot.open()
    assert fresh(rig)
    assert len(rig.pilot.check_parameters()) == 0
    for outcome in (rig.pilot.engage(), rig.pilot.arm(), rig.pilot.take_off(0.3)):
        assert outcome.done, outcome
    assert EventKind.CONTROL_LOST not in rig.pilot.status().conditions


def test_messages_doubled_and_reordered(rigs):
    rig = rigs("px4")
    rig.emulator.start()
    for faults in (rig.emulator.outgoing, rig.emulator.incoming):
        faults.duplicate = faults.reorder = 0.2
    rig.pilot.open()
    assert fresh(rig)
    stamps: list[float] = []
    assert rig.pilot.engage().done and rig.pilot.arm().done
    assert wait_until(lambda: stamps.append(rig.pilot.state().attitude_time) or len(set(stamps)) > 60)
    assert min(np.diff(stamps)) > -0.002, "time runs forwards, to the precision of the clock's map"
    rig.happens(EventKind.DISORDERED)
    assert rig.pilot.status().authority is Authority.ENGAGED


def test_messages_corrupted(rigs):
    rig = rigs("ardupilot")
    rig.emulator.start()
    rig.emulator.outgoing.corrupt = rig.emulator.incoming.corrupt = 0.2
    rig.pilot.open()
    assert fresh(rig)
    assert rig.pilot.engage().done and rig.pilot.arm().done
    assert rig.happens(EventKind.CORRUPTED).values["count"]
    assert np.linalg.norm(rig.pilot.state().position) < 0.1
    assert EventKind.IO_FAILED not in {event.kind for event in rig.seen}


def test_link_cut(rigs):
    rig = rigs("px4").fly()
    rig.forget()
    rig.emulator.outgoing.cut = rig.emulator.incoming.cut = True
    stale = rig.happens(EventKind.STATE_STALE)
    lost = rig.happens(EventKind.LINK_LOST)
    assert rig.pilot.state().status is SampleStatus.STALE
    assert stale.values["age"] > QUICK.state and lost.values["silent"] > QUICK.link
    assert landed(rig), "the autopilot's own failsafe"
    rig.emulator.outgoing.cut = rig.emulator.incoming.cut = False
    rig.happens(EventKind.LINK_LOST, begins=False)
    rig.happens(EventKind.CONTROL_LOST)
    assert not rig.pilot.setpoint(HOVER)


def test_link_slow(rigs):
    """Messages go on coming, each too late: their stamps tell."""
    rig = rigs("px4").open()
    rig.emulator.outgoing.delay = 0.4
    rig.happens(EventKind.STATE_STALE)
    assert wait_until(lambda: rig.pilot.state().status is SampleStatus.STALE)
    assert EventKind.LINK_LOST not in rig.pilot.status().conditions
    rig.emulator.outgoing.delay = 0.0
    assert fresh(rig)


def test_heartbeat_lost(rigs):
    rig = rigs("px4", {"timeouts": replace(QUICK, heartbeat=0.6)}).open()
    rig.emulator.stop_heartbeats()
    assert rig.happens(EventKind.HEARTBEAT_LOST).values["silent"] > 0.6
    assert rig.pilot.status().conditions == {EventKind.HEARTBEAT_LOST}
    rig.emulator.stop_heartbeats(False)
    rig.happens(EventKind.HEARTBEAT_LOST, begins=False)


def test_autopilot_silent_from_the_start(rigs):
    rig = rigs("px4", {"timeouts": replace(QUICK, open=0.3)})
    with pytest.raises(BackendError, match="no heartbeat"):
        rig.pilot.open()
    rig.emulator.start()
    rig.emulator.stop_heartbeats()
    with pytest.raises(BackendError, match="no heartbeat"):
        rig.pilot.open()


def test_device_lost(rigs):
    """A TCP connection, as to a simulator or through a serial server, that breaks and comes back."""
    rig = rigs("px4")
    rig.emulator.start()
    with socket.create_server(("127.0.0.1", 0)) as server, Bridge(server, rig) as bridge:
        pilot = Autopilot(replace(rig.config, connection=f"tcp:127.0.0.1:{server.getsockname()[1]}"))
        rig.pilot.stop()
        rig.pilot = pilot
        pilot.open()
        assert fresh(rig)
        bridge.break_connection()
        rig.happens(EventKind.DEVICE_LOST)
        rig.happens(EventKind.DEVICE_LOST, begins=False)
        assert fresh(rig)
        pilot.stop()


class Bridge:
    """Carries bytes between a TCP connection and the emulator's UDP, until it is told to break."""

    def __init__(self, server: socket.socket, rig: Rig) -> None:
        self._server, self._rig = server, rig
        self._udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._udp.bind(("127.0.0.1", rig.port))
        self._udp.settimeout(0.05)
        self._stop, self._break = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> Bridge:
        self._server.settimeout(5.0)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join(6.0)
        self._udp.close()

    def break_connection(self) -> None:
        self._break.set()

    def _run(self) -> None:
        while not self._stop.is_set():
            try:
                connection, _ = self._server.accept()
            except TimeoutError:
                return
            with connection:
                connection.setblocking(False)
                while not self._stop.is_set() and not self._break.is_set():
                    self._carry(connection)
            self._break.clear()

    def _carry(self, connection: socket.socket) -> None:
        try:
            connection.sendall(self._udp.recv(65536))
        except (TimeoutError, BlockingIOError, ConnectionError):
            pass
        try:
            data = connection.recv(65536)
        except (BlockingIOError, ConnectionError):
            return
        for start in range(0, len(data), 1000):
            self._udp.sendto(data[start : start + 1000], self._rig.emulator.address)


def test_own_thread_fails(rigs, monkeypatch):
    rig = rigs("px4").open()
    rig.pilot.engage()

    def fail(*_: object) -> None:
        raise RuntimeError("injected")

    monkeypatch.setattr(rig.pilot._link.tracker, "take", fail)
    assert "injected" in rig.happens(EventKind.IO_FAILED).message
    assert rig.pilot.state().status is SampleStatus.STALE
    assert not rig.pilot.setpoint(HOVER)


# ---------------------------------------------------------------- who commands


def test_pilot_changes_the_mode(hovering, flavour):
    rig = hovering(flavour)
    assert rig.pilot.setpoint(HOVER)
    rig.emulator.pilot_mode("position")
    assert ("position" if flavour == "px4" else "loiter") in rig.happens(EventKind.CONTROL_LOST).message
    assert not rig.pilot.setpoint(HOVER)
    assert rig.pilot.hold().status is OutcomeStatus.CONTROL_LOST
    assert rig.pilot.land().status is OutcomeStatus.CONTROL_LOST
    counts = rig.emulator.protocol.received
    name = "SET_ATTITUDE_TARGET"
    quiet, beats = counts[name], counts["HEARTBEAT"]
    assert wait_until(lambda: counts["HEARTBEAT"] > beats)
    assert counts[name] <= quiet + 1 and rig.emulator.brain.armed, "nothing is commanded, and nothing falls down"
    assert rig.pilot.engage().done, "only a new request takes it back"


def test_pilot_kills_the_motors(rigs):
    rig = rigs("px4").fly()
    rig.emulator.kill_switch()
    assert "disarmed" in rig.happens(EventKind.CONTROL_LOST).message
    assert not rig.pilot.setpoint(HOVER)


def test_autopilot_loses_its_estimate(rigs):
    rig = rigs("px4").fly()
    rig.emulator.fail_estimator()
    rig.happens(EventKind.CONTROL_LOST)
    rig.happens(EventKind.AUTOPILOT_FAILSAFE)
    rig.says("ailsafe")
    assert landed(rig)


def test_arming_refused(rigs):
    rig = rigs("px4", {"timeouts": replace(QUICK, arming=0.5)}).open()
    assert rig.pilot.engage().done
    rig.emulator.refuse_arming("PreArm: hatch open")
    outcome = rig.pilot.arm()
    assert outcome.status is OutcomeStatus.REFUSED and "hatch open" in outcome.message
    rig.emulator.refuse_arming()
    outcome = rig.pilot.arm(0.2)
    assert outcome.status is OutcomeStatus.REFUSED and not rig.pilot.state().armed
    rig.happens(EventKind.COMMAND_REFUSED)
    rig.emulator.allow_arming()
    assert rig.pilot.arm().done


def test_mode_refused(rigs):
    rig = rigs("ardupilot", {"timeouts": replace(QUICK, mode=0.5, stream_before_mode=0.2)}).open()
    rig.emulator.fail_estimator()
    assert wait_until(lambda: not rig.emulator.estimate.position_valid)
    outcome = rig.pilot.engage()
    assert not outcome.done
    assert rig.pilot.status().authority is Authority.NONE
    counts = rig.emulator.protocol.received
    before, beats = counts["SET_POSITION_TARGET_LOCAL_NED"], counts["HEARTBEAT"]
    assert wait_until(lambda: counts["HEARTBEAT"] > beats)
    assert counts["SET_POSITION_TARGET_LOCAL_NED"] <= before + 1, "the stream has ended"


def test_commands_lost_and_unanswered(rigs):
    rig = rigs("px4").open()
    rig.emulator.protocol.ignore_commands = 2
    assert rig.pilot.engage().done
    rig.emulator.protocol.mute_commands = 2
    assert rig.pilot.arm().done
    rig.emulator.protocol.ignore_commands = 1000
    assert rig.pilot.disarm().status is OutcomeStatus.TIMED_OUT
    rig.happens(EventKind.COMMAND_UNANSWERED)


def test_autopilot_reboots(rigs):
    rig = rigs("px4").fly()
    rig.emulator.reboot(silence=0.3)
    rig.happens(EventKind.REBOOTED)
    rig.happens(EventKind.CONTROL_LOST)
    assert not rig.pilot.setpoint(HOVER)
    assert fresh(rig), "rates are asked for again"
    assert not rig.pilot.state().armed


def test_clock_jumps(hovering):
    rig = hovering("px4")
    rig.emulator.jump_clock(1.5)
    rig.happens(EventKind.CLOCK_JUMPED)
    assert fresh(rig)
    status = rig.pilot.status()
    assert status.clock_offset == pytest.approx(time.monotonic() - rig.emulator.clock, abs=0.5)
    assert status.authority is Authority.ENGAGED
    assert EventKind.REBOOTED not in {event.kind for event in rig.seen}


def test_foreign_systems_talk(rigs):
    rig = rigs("px4").open()
    stranger, station = (7, 1), (254, 190)
    for sender, kind, vendor in ((stranger, 13, 12), (station, 6, 8)):
        rig.emulator.send_as(mavlink.MAVLink_heartbeat_message(kind, vendor, 0x81, 6 << 16, 4, 3), *sender)
        rig.emulator.send_as(mavlink.MAVLink_local_position_ned_message(2**31, 9, 9, 9, 0, 0, 0), *sender)
        rig.emulator.send_as(mavlink.MAVLink_command_ack_message(400, 0), *sender)
    rig.happens(EventKind.FOREIGN)
    assert wait_until(lambda: rig.pilot.status().foreign >= 6)
    sample = rig.pilot.state()
    assert np.linalg.norm(sample.position) < 0.1 and not sample.armed and sample.mode.name == "auto: loiter"


def test_other_vehicle_first(rigs):
    """Told which system to fly, it waits for that one."""
    rig = rigs("px4", {"vehicle_system": 3, "timeouts": replace(QUICK, open=0.3)})
    rig.emulator.start()
    with pytest.raises(BackendError, match="none of a vehicle that is to be flown"):
        rig.pilot.open()
    plane = rigs("px4", {"timeouts": replace(QUICK, open=0.3)}, vehicle_type=1)
    plane.emulator.start()
    with pytest.raises(BackendError, match="multirotor"):
        plane.pilot.open()


def test_signature_missing(rigs, tmp_path):
    key = tmp_path / "key"
    key.write_bytes(bytes(range(32)))
    key.chmod(0o600)
    rig = rigs("px4", {"signing_key": key, "timeouts": replace(QUICK, open=0.3)})
    rig.emulator.start()
    with pytest.raises(BackendError, match="signatures"):
        rig.pilot.open()
    rig.happens(EventKind.BAD_SIGNATURE)
    signed = rigs("px4", {"signing_key": key}, signing_key=bytes(range(32))).open()
    assert signed.pilot.engage().done and signed.pilot.arm().done
    signed.emulator.send_as(mavlink.MAVLink_heartbeat_message(13, 12, 0x81, POSITION, 4, 3), 1, 1)
    signed.happens(EventKind.BAD_SIGNATURE)
    assert signed.pilot.status().authority is Authority.ENGAGED


# ---------------------------------------------------------------- what goes in and out


def test_controller_silent(hovering, flavour):
    rig = hovering(flavour)
    assert rig.pilot.setpoint(AttitudeSetpoint(WEIGHT, np.array([0.0, 0.1, 0.0])))
    silent = rig.happens(EventKind.SETPOINT_STALE)
    assert silent.values["silent"] > QUICK.setpoint
    assert wait_until(lambda: rig.emulator.brain.demand.task is Task.POSITION), "it holds where it is"
    assert rig.pilot.status().authority is Authority.ENGAGED
    assert rig.pilot.setpoint(HOVER)
    rig.happens(EventKind.SETPOINT_STALE, begins=False)


def test_setpoint_not_a_number(rigs):
    rig = rigs("px4").open()
    for bad in (np.nan, np.inf, 1e30):
        with pytest.raises(BackendError.__base__, match="setpoint"):
            rig.pilot.setpoint(AttitudeSetpoint(bad, np.zeros(3)))
        with pytest.raises(BackendError.__base__, match="setpoint"):
            rig.pilot.setpoint(PositionSetpoint(np.array([0.0, bad, 0.0]), 0.0))


def test_state_not_a_number(rigs):
    rig = rigs("px4").open()
    nan = float("nan")
    for stamp in range(5):
        message = mavlink.MAVLink_local_position_ned_message(2**30 + stamp, nan, 0, 0, 0, 0, 0)
        rig.emulator.send(message)
    rig.happens(EventKind.INVALID_DATA)
    assert np.isfinite(rig.pilot.state().position).all()


def test_mocap_lost(rigs):
    rig = rigs("px4", {"mocap": True, "timeouts": replace(QUICK, mocap=0.3)}, vision=True, pace=1.0).open()
    stop = threading.Event()

    def feed() -> None:
        while not stop.wait(0.01):
            truth = rig.emulator.truth
            rig.pilot.mocap(time.monotonic(), truth.position, truth.quaternion)

    thread = threading.Thread(target=feed)
    thread.start()
    try:
        assert fresh(rig) and wait_until(lambda: rig.emulator.estimate.position_valid)
        for outcome in (rig.pilot.engage(), rig.pilot.arm(), rig.pilot.take_off(0.3)):
            assert outcome.done, outcome
    finally:
        stop.set()
        thread.join(5.0)
    assert rig.happens(EventKind.MOCAP_LOST).values["silent"] > 0.3
    assert wait_until(lambda: rig.emulator.brain.mode == LAND)
    assert wait_until(lambda: rig.pilot.status().authority in (Authority.LANDING, Authority.NONE))
    assert landed(rig)


def test_battery_low(rigs):
    rig = rigs("px4", {"min_voltage": 14.0}).open()
    assert EventKind.BATTERY_LOW not in rig.pilot.status().conditions
    rig.emulator.battery.remaining = 0.1
    rig.happens(EventKind.BATTERY_LOW)
    rig.emulator.battery.remaining = 0.9
    rig.happens(EventKind.BATTERY_LOW, begins=False)
    rig.forget()
    rig.emulator.battery.voltage = 13.0
    assert rig.happens(EventKind.BATTERY_LOW).values["voltage"] == pytest.approx(13.0)


# ---------------------------------------------------------------- the end of this process


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
    rig = rigs("px4")
    rig.emulator.start()
    script = [sys.executable, "-c", textwrap.dedent(FLYER), str(rig.port)]
    with subprocess.Popen(script, stderr=subprocess.PIPE) as process:
        try:
            flying = wait_until(lambda: rig.emulator.brain.demand.task is Task.ATTITUDE or process.poll(), 30.0)
            assert flying and process.poll() is None, process.stderr.read() if process.stderr else None
        finally:
            os.kill(process.pid, signal.SIGKILL)
    assert landed(rig)
    assert rig.emulator.brain.mode == LAND


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
    rig.pilot._link.stop()
    assert wait_until(lambda: rig.emulator.brain.mode == RETURN)
    height = rig.emulator.truth.position[2]
    assert wait_until(lambda: rig.emulator.truth.position[2] > height + 0.2)
