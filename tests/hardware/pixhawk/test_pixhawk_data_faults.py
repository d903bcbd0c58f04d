"""Faults of what goes in and out, injected on real sockets; the table in docs/hardware/pixhawk.md names these tests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pixhawk_rig import HOVER, QUICK, WEIGHT, fresh, landed, wait_until
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from virtual_time import CLOCK

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk import AttitudeSetpoint, Authority, EventKind, PositionSetpoint
from doorman.hardware.pixhawk.link.stream import LONGEST_BLIND_HOLD
from doorman.rig.emulators.autopilot.control import Task


def test_controller_silent(hovering, flavour):
    rig = hovering(flavour)
    assert rig.pilot.setpoint(AttitudeSetpoint(WEIGHT, np.array([0.0, 0.1, 0.0])))
    silent = rig.happens(EventKind.SETPOINT_STALE)
    assert silent.values["silent"] > QUICK.setpoint
    assert wait_until(lambda: rig.emulator.brain.demand.task is Task.POSITION), "it holds where it is"
    assert rig.pilot.status().authority is Authority.ENGAGED
    assert rig.pilot.setpoint(HOVER)
    rig.happens(EventKind.SETPOINT_STALE, begins=False)


def test_controller_silent_where_nobody_knows_the_place(hovering):
    """ArduPilot would level and drift as long as our heartbeats come."""
    rig = hovering("ardupilot")
    rig.emulator.outgoing.cut = True
    begin = CLOCK.now()
    while CLOCK.now() < begin + LONGEST_BLIND_HOLD + 0.1:
        assert rig.pilot.setpoint(HOVER)
        CLOCK.sleep(0.02)
    assert not rig.emulator.brain.is_in("land")
    assert wait_until(lambda: rig.emulator.brain.is_in("land"))


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
    stop = CLOCK.event()

    def feed() -> None:
        while not stop.wait(0.01):
            truth = rig.emulator.truth
            rig.pilot.mocap(CLOCK.now(), truth.position, truth.quaternion)

    thread = CLOCK.thread(feed)
    thread.start()
    try:
        assert fresh(rig) and wait_until(lambda: rig.emulator.estimator.estimate.position_valid)
        for outcome in (rig.pilot.engage(), rig.pilot.arm(), rig.pilot.take_off(0.3)):
            assert outcome.done, outcome
    finally:
        stop.set()
        thread.join(5.0)
    assert rig.happens(EventKind.MOCAP_LOST).values["silent"] > 0.3
    assert wait_until(lambda: rig.emulator.brain.is_in("land"))
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


def test_battery_silent(rigs):
    rig = rigs("px4", {"timeouts": replace(QUICK, battery=1.0)}).open()
    assert wait_until(lambda: rig.pilot.state().battery.remaining > 0.8)
    assert EventKind.BATTERY_SILENT not in rig.pilot.status().conditions
    rig.emulator.battery.silent = True
    rig.happens(EventKind.BATTERY_SILENT)
    rig.emulator.battery.silent = False
    rig.happens(EventKind.BATTERY_SILENT, begins=False)
