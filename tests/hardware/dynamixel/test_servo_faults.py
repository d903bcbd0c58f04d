"""Faults of the servos themselves, from docs/hardware/servos.md: injected, told, and brought to their end state."""

from __future__ import annotations

import numpy as np
import pytest
from servo_rig import SLOW, assert_moving, assert_stopped, follows, goes_on, has, holds, stops_by
from virtual_time import CLOCK

from doorman.hardware.dynamixel import STOPPING, ServoFault
from doorman.rig.emulators.servos.bus import LaggingJoints, ServoMotion
from doorman.rig.emulators.servos.unit import ENCODER, OVERLOAD, READY, SHOCK, ServoSetup


@pytest.mark.parametrize(
    ("row", "value", "fault"),
    [("present temperature", 62, ServoFault.WARM), ("present input voltage", 92, ServoFault.VOLTAGE)],
)
def test_what_is_only_reported(rig, row, value, fault):
    rig.set_row(2, row, value)
    sample = rig.until(has(fault), rates=SLOW)
    assert follows(sample)
    assert (sample.temperatures[1], sample.voltages[1]) in ((62.0, 12.0), (30.0, pytest.approx(9.2)))
    assert_moving(rig)


def test_hot_servo(rig):
    rig.fly(SLOW, 0.05)
    rig.set_row(2, "present temperature", 71)
    stops_by(rig, ServoFault.HOT)
    rig.set_row(2, "present temperature", 67)
    assert holds(rig.fly(SLOW, 0.05)[-1]), "not yet cold enough"
    rig.set_row(2, "present temperature", 64)
    rig.until(follows, rates=SLOW)
    assert rig.row(2, "torque enable") == 1, "it never gave way"
    told = [str(event) for event in rig.events() if event.fault is ServoFault.HOT]
    assert told == ["servo 2: hot began", "servo 2: hot ended"]


@pytest.mark.parametrize(("bits", "fault"), [(OVERLOAD, ServoFault.OVERLOAD), (SHOCK, ServoFault.SHOCK)])
def test_servo_that_shuts_down(rig, bits, fault):
    rig.fly(SLOW, 0.05)
    rig.trip(3, bits)
    stops_by(rig, fault)
    assert rig.bus.read().errors[2] & bits
    goes_on(rig, recovered=True)
    assert rig.row(3, "hardware error status") == 0
    assert rig.began(fault, servo_id=3)
    assert any(event.text == "set up again" for event in rig.events())


def test_servo_that_does_not_know_its_angle(rig):
    """As delivered it keeps its torque, and turns on whatever it is told."""
    rig.fly(SLOW, 0.05)
    rig.trip(3, ENCODER)
    sample = rig.until(has(ServoFault.ENCODER), rates=SLOW)
    assert holds(sample)
    seen = sample.times[2]
    stops_by(rig, ServoFault.TORQUE_OFF)
    assert rig.rows("torque enable") == [1, 1, 0, 1]
    sample = rig.until(has(ServoFault.MISSING), rates=SLOW)
    assert sample.times[2] == seen, "its angle is as old as the last that it saw"
    assert not sample.fresh
    assert [bool(fault & STOPPING) for fault in sample.faults] == [False, False, True, False]
    goes_on(rig, recovered=True)


@pytest.mark.parametrize("degrees", [5.0, -15.0])
def test_servo_whose_angle_jumps(rig, degrees):
    """It does not know itself that its zero is another one."""
    before = rig.fly(SLOW, 0.05)[-1]
    rig.set_row(3, "homing offset", round(degrees / 360.0 * 4096))
    sample = rig.until(has(ServoFault.JUMPED), rates=SLOW)
    assert sample.cycle - before.cycle <= 3
    rig.until(holds, rates=SLOW)
    assert_stopped(rig)
    sample = rig.until(has(ServoFault.MISSING), rates=SLOW)
    assert sample.angles[2] == pytest.approx(before.angles[2], abs=0.02), "the one before the jump"
    assert sample.times[2] < sample.times[0] - 0.9 * rig.config.missing_after, "it ages"
    assert [bool(fault & ServoFault.JUMPED) for fault in sample.faults] == [False, False, True, False]
    rig.set_row(3, "homing offset", 0)
    goes_on(rig, recovered=True)


def test_a_supply_that_dips_where_the_servo_shuts_down_by_it(make_rig, make_emulator):
    """Only a reboot brings its torque back then."""
    careful = [ServoSetup(number, {**READY, "shutdown": 0x35}) for number in (1, 2, 3, 4)]
    rig = make_rig(make_emulator(careful))
    rig.bus.open()
    rig.fly(SLOW, 0.05)
    rig.set_row(2, "present input voltage", 92)
    stops_by(rig, ServoFault.TORQUE_OFF)
    rig.set_row(2, "present input voltage", 120)
    goes_on(rig, recovered=True)


def test_recoveries_come_one_after_the_other_and_keep_the_other_servos_alive(rig):
    """None is forgotten."""
    rig.trip(3, OVERLOAD)
    with rig.emulator.lock:
        rig.servo(3).setup.boot_time = 0.5
    rig.until(has(ServoFault.OVERLOAD))
    said = []
    callers = [CLOCK.thread(lambda: said.append(rig.bus.recover())) for _ in range(3)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join(10.0)
    assert said == [(), (), ()]
    assert rig.until(follows, rates=SLOW).fresh
    assert not [event for event in rig.events() if "cleared and set again" in event.text], "a watchdog fired meanwhile"


def test_servo_that_shuts_down_by_heat(rig):
    rig.set_row(4, "present temperature", 85)
    rig.until(has(ServoFault.OVERHEATING), rates=SLOW)
    (failure,) = rig.bus.recover()
    assert "servo 4: the servo is too hot to be rebooted" in failure
    assert holds(rig.fly(SLOW, 0.05)[-1])
    rig.set_row(4, "present temperature", 50)
    goes_on(rig, recovered=True)


def test_servo_that_does_not_recover(rig):
    with rig.emulator.lock:
        rig.servo(1).lasting_errors = ENCODER
    rig.until(has(ServoFault.ENCODER), rates=SLOW)
    (failure,) = rig.bus.recover()
    assert "servo 1: a hardware error persists after a reboot" in failure
    assert_stopped(rig)


def test_strained_servo(make_rig, make_emulator):
    class Strained(LaggingJoints):
        def motion(self, time: float) -> ServoMotion:
            motion = super().motion(time)
            return ServoMotion(motion.angles, motion.rates, np.array([0.0, -1.5, 0.0, 0.0]))

    rig = make_rig(make_emulator(plant=Strained(np.zeros(4))))
    rig.bus.open()
    sample = rig.until(has(ServoFault.STRAINED), rates=SLOW)
    assert sample.faults[1] & ServoFault.STRAINED
    assert sample.currents[1] == pytest.approx(-1.5, abs=0.002)
    assert follows(sample)


def test_bus_watchdog_fired(rig):
    rig.fly(SLOW, 0.05)
    servo, written = rig.servo(1), []
    with rig.emulator.lock:
        write = servo.write
        servo.write = lambda address, data: (
            written.append((address, int.from_bytes(data, "little"))) or write(address, data)
        )
    rig.set_row(1, "bus watchdog", 0xFF)
    rig.until(lambda sample: bool(rig.began(ServoFault.WATCHDOG, servo_id=1)), rates=SLOW)
    rig.until(follows, rates=SLOW)
    assert rig.row(1, "bus watchdog") == rig.config.watchdog_counts
    cleared = written.index((98, 0))
    assert written[cleared + 1 : cleared + 5] == [(104, 0), (98, 0), (104, 0), (98, rig.config.watchdog_counts)]
    assert_moving(rig)


@pytest.mark.parametrize("at", ["open", "rest"])
def test_the_goal_is_zero_before_the_clearing_of_a_watchdog_is_answered(rig, at):
    """An answer may take long to come, and the servo would pursue its old goal meanwhile."""
    if at == "open":
        rig.bus.stop()
    servo, goals = rig.servo(1), []
    with rig.emulator.lock:
        execute = servo.execute

        def watched(now, instruction):
            if instruction.code == 0x03 and instruction.parameters == b"\x62\x00\x00":
                goals.append(servo.memory.get("goal velocity"))
            return execute(now, instruction)

        servo.execute = watched
        servo.memory.set("goal velocity", 40)
        servo.memory.set("bus watchdog", 0xFF)
    rig.bus.open() if at == "open" else rig.bus.stop()
    assert goals and not any(goals)


def test_restarted_servo(rig):
    """A dip of the supply: it forgets its set-up and shows zeros, which are not taken for a position."""
    rig.fly(SLOW, 0.2)
    angle = rig.true_angles()[1]
    with rig.emulator.lock:
        rig.servo(2).setup.boot_time = 0.02
        rig.servo(2).reboot(CLOCK.now())
    sample = stops_by(rig, ServoFault.RESTARTED)
    assert sample.angles[1] == pytest.approx(angle, abs=0.02)
    assert not rig.bus.read().fresh
    goes_on(rig, recovered=True)
    assert rig.bus.read().angles[1] == pytest.approx(rig.true_angles()[1], abs=0.02)


def test_torque_switched_off(rig):
    rig.fly(SLOW, 0.05)
    rig.set_row(4, "torque enable", 0)
    stops_by(rig, ServoFault.TORQUE_OFF)
    rig.set_row(4, "torque enable", 1)
    goes_on(rig, recovered=True)


def test_another_model_in_the_place_of_a_servo(rig):
    rig.emulator.faults.silent.add(2)
    rig.until(has(ServoFault.MISSING))
    rig.set_row(2, "model number", 1020)
    rig.emulator.faults.silent.clear()
    stops_by(rig, ServoFault.WRONG_MODEL)
    (failure,) = rig.bus.recover()
    assert "servo 2: wrong model" in failure
    assert_stopped(rig)


def test_joint_outside_its_limits(make_rig, make_emulator):
    rig = make_rig(make_emulator(angles=[0.0, 1.75, 0.0, 0.0]))
    rig.bus.open()
    sample = rig.until(has(ServoFault.OUT_OF_LIMITS))
    assert sample.faults[1] & ServoFault.OUT_OF_LIMITS
    rig.fly([0.2, 0.5, 0.0, 0.0], 0.2)
    assert rig.true_angles()[1] == pytest.approx(1.75, abs=1e-6)
    rig.fly([0.0, -1.0, 0.0, 0.0], 0.3)
    assert rig.true_angles()[1] < 1.65
    assert not rig.bus.read().fault & ServoFault.OUT_OF_LIMITS
