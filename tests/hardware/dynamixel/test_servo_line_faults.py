"""Faults of line, device, user and program, from docs/hardware/servos.md: injected, told, and brought to their end state."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from servo_rig import FASTEST, LOWER, SLOW, UPPER, assert_moving, follows, goes_on, has, holds, stops_by
from virtual_time import CLOCK

from doorman.clocks import REAL_TIME
from doorman.hardware.dynamixel import LATCHED, STOPPING, BusState, ServoFault

# ---------------------------------------------------------------- answers


@pytest.mark.parametrize(
    ("kind", "fault"), [("drop", ServoFault.TIMEOUT), ("corrupt", ServoFault.CORRUPT), ("truncate", ServoFault.CORRUPT)]
)
def test_single_answers_lost_or_damaged(rig, kind, fault):
    setattr(rig.emulator.faults, kind, 0.05)
    start = rig.true_angles()
    rig.fly(SLOW, 0.4)
    setattr(rig.emulator.faults, kind, 0.0)
    assert rig.began(fault)
    assert (rig.true_angles() - start > 0.04).all(), "the arm went on"
    rig.until(lambda sample: sample.fault is ServoFault.NONE, rates=SLOW)


@pytest.mark.parametrize(("kind", "share"), [("noise", 0.5), ("deafness", 0.1), ("echo", True)])
def test_an_arm_goes_on(rig, kind, share):
    """With noise before answers, instructions that are damaged, or an adapter that echoes."""
    setattr(rig.emulator.faults, kind, share)
    start = rig.true_angles()
    rig.fly(SLOW, 0.3)
    assert (rig.true_angles() - start > 0.02).all()
    assert not any(event.fault in LATCHED for event in rig.events())
    if kind == "echo":
        rig.until(lambda sample: sample.fault is ServoFault.NONE, rates=SLOW)
        assert_moving(rig)


def test_flooded_bus(rig):
    rig.fly(SLOW, 0.05)
    rig.emulator.faults.mute.update({1, 2, 3, 4})
    rig.emulator.faults.babble = True
    stops_by(rig, ServoFault.STALE)
    rig.emulator.faults.babble = False
    rig.emulator.faults.mute.clear()
    goes_on(rig)


def test_servo_that_hears_but_does_not_answer(rig):
    """The first of the chain, which silences all others in a sync read."""
    rig.fly(SLOW, 0.05)
    rig.emulator.faults.mute.add(1)
    stops_by(rig, ServoFault.STALE)
    sample = rig.until(has(ServoFault.MISSING), rates=SLOW)
    assert not sample.fresh
    sample = rig.until(lambda sample: sum(bool(f & STOPPING) for f in sample.faults) == 1, rates=SLOW)
    assert sample.faults[0] & ServoFault.MISSING, "the silent one and none of those that it silenced"
    assert sample.times[0] < sample.times.max() - 0.2
    rig.emulator.faults.mute.clear()
    goes_on(rig)


def test_missing_servo(rig):
    """A broken cable: the servo hears nothing, so its own watchdog fires; it is set again when the servo is back."""
    rig.fly(SLOW, 0.05)
    rig.emulator.faults.silent.add(2)
    stops_by(rig, ServoFault.MISSING)
    counts = rig.config.watchdog_counts
    assert rig.rows("bus watchdog") == [counts, 0xFF, counts, counts]
    rig.emulator.faults.silent.clear()
    goes_on(rig)
    assert rig.row(2, "bus watchdog") == counts
    assert [event.servo_id for event in rig.events() if "cleared and set again" in event.text] == [2]


def test_all_servos_missing(rig):
    rig.fly(SLOW, 0.05)
    rig.emulator.faults.silent.update({1, 2, 3, 4})
    rig.until(lambda sample: all(fault & ServoFault.MISSING for fault in sample.faults), rates=SLOW)
    rig.emulator.faults.silent.clear()
    goes_on(rig)


def test_answers_that_come_too_late(rig):
    rig.fly(SLOW, 0.05)
    rig.emulator.faults.delay = 0.03
    stops_by(rig, ServoFault.STALE)
    rig.emulator.faults.delay = 0.0
    goes_on(rig)


def test_frozen_servo(rig):
    """It repeats its last answer: right in every byte but old."""
    rig.fly(SLOW, 0.05)
    rig.emulator.faults.frozen.add(3)
    assert stops_by(rig, ServoFault.STALE).faults[2] & ServoFault.LATE
    assert not rig.until(has(ServoFault.MISSING), rates=SLOW).fresh
    rig.emulator.faults.frozen.clear()
    goes_on(rig)


def test_nothing_old_is_passed_on_as_fresh(rig):
    """Whatever the wire does, an entry is where the joint was at the entry's time."""
    faults = rig.emulator.faults
    truth: list[tuple[float, np.ndarray]] = []
    said: list[dict[float, float]] = [{}, {}, {}, {}]
    for cycle in range(60):
        faults.delay = (0.0, 0.007, 0.015)[cycle // 10 % 3]
        faults.drop = faults.corrupt = 0.1 * (cycle // 30 % 2)
        rig.bus.command([1.0 if cycle // 30 % 2 else -1.0] * 4)
        sample = rig.bus.wait(rig.bus.read(), 1.0)
        with rig.emulator.lock:
            now = CLOCK.now()
            truth.append((now, rig.emulator.plant.motion(now).angles))
        for joint in range(4):
            said[joint][float(sample.times[joint])] = float(sample.angles[joint])
    times = np.array([when for when, _ in truth])
    for joint in range(4):
        angles = np.array([angles[joint] for _, angles in truth])
        inside = {when: angle for when, angle in said[joint].items() if times[0] < when < times[-1]}
        assert len(inside) > 10
        for when, angle in inside.items():
            after = int(np.searchsorted(times, when))
            near = angles[max(after - 2, 0) : after + 2]
            assert near.min() - 0.008 <= angle <= near.max() + 0.008


# ---------------------------------------------------------------- device, user, program


@pytest.fixture
def unplugged(make_rig, make_emulator, tmp_path):
    """A bus whose device was unplugged while the arm moved."""
    rig = make_rig(make_emulator(link=tmp_path / "servos"))
    rig.bus.open()
    rig.fly(SLOW, 0.05)
    rig.emulator.unplug()
    assert rig.until(has(ServoFault.UNPLUGGED), rates=SLOW).state is BusState.DISCONNECTED
    return rig


def test_unplugged_and_plugged_in_again(unplugged):
    CLOCK.sleep(0.35)
    assert not unplugged.bus.read().fresh
    assert unplugged.bus.recover(0.2) != ()
    assert unplugged.true_rates() == pytest.approx(0.0, abs=1e-3), "the servos' own watchdogs"
    unplugged.emulator.plug_in()
    goes_on(unplugged)
    assert {event.servo_id for event in unplugged.events() if "cleared and set again" in event.text} == {1, 2, 3, 4}


def test_unplugged_and_another_arm_plugged_in(unplugged):
    unplugged.set_row(3, "model number", 1010)
    unplugged.emulator.plug_in()
    CLOCK.sleep(0.25)
    assert unplugged.bus.read().state is BusState.DISCONNECTED


def test_power_lost_while_unplugged(unplugged):
    """The arm went limp: torque does not come back by itself."""
    with unplugged.emulator.lock:
        for servo_id in (1, 2, 3, 4):
            unplugged.servo(servo_id).reboot(CLOCK.now())
    CLOCK.sleep(0.15)
    unplugged.emulator.plug_in()
    assert holds(unplugged.until(has(ServoFault.RESTARTED), rates=SLOW))
    assert unplugged.rows("torque enable") == [0, 0, 0, 0]
    goes_on(unplugged, recovered=True)


def test_user_that_falls_silent(make_rig):
    rig = make_rig(command_timeout=0.1)
    rig.bus.open()
    rig.fly(SLOW, 0.2)
    sample = rig.until(has(ServoFault.COMMAND_STALE))
    assert holds(sample)
    assert not sample.goals.any()
    CLOCK.sleep(0.15)
    assert rig.true_rates() == pytest.approx(0.0, abs=1e-3)
    rig.until(follows, rates=SLOW)


def test_user_that_has_stopped_the_arm_may_fall_silent(make_rig):
    rig = make_rig(command_timeout=0.05)
    rig.bus.open()
    rig.bus.command([0.0] * 4)
    CLOCK.sleep(0.2)
    assert rig.bus.read().fault is ServoFault.NONE


@pytest.mark.parametrize("place", ["_faults", "_send"])
def test_adapter_that_fails_in_itself(rig, monkeypatch, place):
    """Before it has commanded anything, or after: questions alone keep the servos' watchdogs quiet."""
    rig.fly(SLOW, 0.2)
    cycle = rig.bus._cycle
    broken = [True]
    whole = getattr(cycle, place)

    def failing(*arguments):
        result = whole(*arguments)
        if broken and sys._getframe(1).f_code.co_name == "step":
            raise RuntimeError("a mistake of ours")
        return result

    monkeypatch.setattr(cycle, place, failing)
    end = CLOCK.now() + 2.0
    while not rig.began(ServoFault.INTERNAL):
        assert CLOCK.now() < end
        CLOCK.sleep(0.01)
    assert "RuntimeError: a mistake of ours" in rig.began(ServoFault.INTERNAL)[0].text
    CLOCK.sleep(0.2)
    assert rig.true_rates() == pytest.approx(0.0, abs=1e-3)
    assert rig.bus.read().state is BusState.HOLDING
    assert rig.row(1, "bus watchdog") == rig.config.watchdog_counts
    broken.clear()
    assert rig.bus.recover() == ()
    rig.until(follows, rates=SLOW)


FLIGHT = """
import sys, time
from doorman.hardware.dynamixel import ServoBus, ServoConfig
with ServoBus(ServoConfig(sys.argv[1], {lower}, {upper}, {fastest}, stale_after=0.06, latency=0.012)) as bus:
    print("flying", flush=True)
    while True:
        bus.command([0.2] * 4)
        time.sleep(0.005)
"""


def wait_for(condition: Callable[[], bool]) -> None:
    """Wait in real time for what another process does; an error if it does not come."""
    end = REAL_TIME.now() + 20.0
    while not condition():
        assert REAL_TIME.now() < end
        REAL_TIME.sleep(0.005)


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_program_killed_or_frozen(make_emulator, how):
    """Nobody is left to command zero velocity: the servos' bus watchdogs do it."""
    emulator = make_emulator(clock=REAL_TIME)
    code = FLIGHT.format(lower=LOWER, upper=UPPER, fastest=FASTEST)
    root = Path(__file__).parents[3]
    program = subprocess.Popen(
        [sys.executable, "-c", code, emulator.port], stdout=subprocess.PIPE, env={**os.environ, "PYTHONPATH": str(root)}
    )
    try:
        assert program.stdout is not None
        assert program.stdout.readline() == b"flying\n"
        wait_for(lambda: (emulator.plant.motion(REAL_TIME.now()).rates > 0.1).all())
        program.send_signal(how)
        wait_for(lambda: np.abs(emulator.plant.motion(REAL_TIME.now()).rates).max() < 1e-3)
        for servo_id in (1, 2, 3, 4):
            assert emulator.servo(servo_id).memory.get("bus watchdog") == 0xFF
            assert emulator.servo(servo_id).memory.get("torque enable") == 1
    finally:
        program.kill()
        program.wait(5.0)
        program.stdout.close()
