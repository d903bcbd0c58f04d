"""Faults of the link, injected on real sockets; the table in docs/hardware/pixhawk.md names these tests."""

from __future__ import annotations

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest
from pixhawk_rig import HOVER, QUICK, fresh, landed, wait_until

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk import Authority, EventKind, SampleStatus
from doorman.hardware.pixhawk.wire.transport import DeviceLost


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


def test_device_lost(rigs, monkeypatch):
    """As a cable that is pulled, or a connection that breaks; that lines notice it themselves is shown with them."""
    rig = rigs("px4").open()
    monkeypatch.setattr(rig.pilot._link._line, "receive", Mock(side_effect=DeviceLost("unplugged")))
    assert "unplugged" in rig.happens(EventKind.DEVICE_LOST).message
    rig.happens(EventKind.DEVICE_LOST, begins=False)
    assert fresh(rig) and rig.pilot.engage().done


def test_own_thread_fails(rigs, monkeypatch):
    rig = rigs("px4").open()
    rig.pilot.engage()

    def fail(*_: object) -> None:
        raise RuntimeError("injected")

    monkeypatch.setattr(rig.pilot._link.tracker, "take", fail)
    assert "injected" in rig.happens(EventKind.IO_FAILED).message
    assert rig.pilot.state().status is SampleStatus.STALE
    assert not rig.pilot.setpoint(HOVER)
