"""Faults of the link, injected on real sockets; the table in docs/hardware/pixhawk.md names these tests."""

from __future__ import annotations

import socket
from dataclasses import replace

import numpy as np
import pytest
from pixhawk_rig import HOVER, QUICK, Rig, fresh, landed, wait_until
from virtual_time import CLOCK

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk import Authority, Autopilot, EventKind, SampleStatus


def test_messages_lost(rigs):
    rig = rigs("ardupilot")
    rig.emulator.parameters["FS_GCS_TIMEOUT"] = 10.0
    rig.emulator.open()
    rig.emulator.outgoing.loss = rig.emulator.incoming.loss = 0.2
    rig.pilot.open()
    assert fresh(rig)
    assert len(rig.pilot.check_parameters()) == 0
    for outcome in (rig.pilot.engage(), rig.pilot.arm(), rig.pilot.take_off(0.3)):
        assert outcome.done, outcome
    assert EventKind.CONTROL_LOST not in rig.pilot.status().conditions


def test_messages_doubled_and_reordered(rigs):
    rig = rigs("px4")
    rig.emulator.open()
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
    rig.emulator.open()
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
    assert stale.values["silent"] > QUICK.state and lost.values["silent"] > QUICK.link
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
    rig.emulator.telemetry.heartbeats_stopped = True
    assert rig.happens(EventKind.HEARTBEAT_LOST).values["silent"] > 0.6
    assert rig.pilot.status().conditions == {EventKind.HEARTBEAT_LOST}
    rig.emulator.telemetry.heartbeats_stopped = False
    rig.happens(EventKind.HEARTBEAT_LOST, begins=False)


def test_autopilot_silent_from_the_start(rigs):
    rig = rigs("px4", {"timeouts": replace(QUICK, open=0.3)})
    with pytest.raises(BackendError, match="no heartbeat"):
        rig.pilot.open()
    rig.emulator.open()
    rig.emulator.telemetry.heartbeats_stopped = True
    with pytest.raises(BackendError, match="no heartbeat"):
        rig.pilot.open()


def test_device_lost(rigs):
    """A TCP connection, as to a simulator or through a serial server, that breaks and comes back."""
    rig = rigs("px4")
    rig.emulator.open()
    with socket.create_server(("127.0.0.1", 0)) as server, Bridge(server, rig) as bridge:
        pilot = Autopilot(replace(rig.config, connection=f"tcp:127.0.0.1:{server.getsockname()[1]}"), CLOCK)
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
        self._udp.setblocking(False)
        self._stop, self._break = CLOCK.event(), CLOCK.event()
        self._thread = CLOCK.thread(self._run)

    def __enter__(self) -> Bridge:
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
            if not CLOCK.readable([self._server], 5.0):
                return
            connection, _ = self._server.accept()
            with connection:
                connection.setblocking(False)
                while not self._stop.is_set() and not self._break.is_set():
                    self._carry(connection)
            self._break.clear()

    def _carry(self, connection: socket.socket) -> None:
        CLOCK.readable([self._udp, connection], 0.05)
        try:
            connection.sendall(self._udp.recv(65536))
        except (BlockingIOError, ConnectionError):
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
