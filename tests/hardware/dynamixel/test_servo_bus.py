"""The servo bus on emulated servos: what it reads, how it moves them, how it begins and ends."""

from __future__ import annotations

import os
import threading

import numpy as np
import pytest
from servo_rig import LOWER, UPPER, follows
from virtual_time import CLOCK

from doorman.exceptions import BackendError
from doorman.hardware.dynamixel import BusState, ServoFault
from doorman.hardware.dynamixel.registers import Unit
from doorman.rig.emulators.servos.unit import READY, ServoSetup

POSTURE = [0.3, 1.0, -0.6, -0.4]


def test_angles_are_those_of_the_joints(make_rig, make_emulator):
    zeros, directions = (2048, 1000, 3100, 2048), (1, -1, 1, -1)
    servos = [ServoSetup(k + 1, dict(READY), zeros[k], directions[k]) for k in range(4)]
    rig = make_rig(make_emulator(servos, angles=POSTURE), zero_positions=zeros, directions=directions)
    rig.bus.open()
    sample = rig.bus.read()
    assert sample.angles == pytest.approx(POSTURE, abs=Unit.ANGLE)
    assert sample.rates == pytest.approx(0.0)
    rates = [0.5, -0.5, 0.4, 0.3]
    samples = rig.fly(rates, 0.25)
    assert samples[-1].rates == pytest.approx(rates, abs=2 * Unit.VELOCITY)
    assert rig.true_rates() == pytest.approx(rates, abs=2 * Unit.VELOCITY)
    assert np.array_equal(np.sign(rig.true_angles() - POSTURE), np.sign(rates))


def test_a_sample_says_everything(rig):
    for servo_id in (1, 2, 3, 4):
        rig.set_row(servo_id, "present temperature", 40 + servo_id)
        rig.set_row(servo_id, "present input voltage", 110 + servo_id)
    before = CLOCK.now()
    sample = rig.until(lambda sample: sample.time > before)
    assert sample.temperatures == pytest.approx([41, 42, 43, 44])
    assert sample.voltages == pytest.approx([11.1, 11.2, 11.3, 11.4])
    assert sample.currents.shape == (4,)
    assert sample.errors == (0, 0, 0, 0)
    assert sample.fault is ServoFault.NONE
    assert sample.state is BusState.FOLLOWING
    assert sample.fresh
    assert 0.0 <= sample.age < rig.config.stale_after
    assert (sample.times >= before).all()
    with pytest.raises(ValueError, match="read-only"):
        sample.angles[0] = 0.0


def test_samples_follow_each_other_with_times_that_grow(rig):
    samples = [rig.bus.read()]
    for _ in range(30):
        samples.append(rig.bus.wait(samples[-1], 1.0))
    assert (np.diff([sample.cycle for sample in samples]) >= 1).all()
    assert (np.diff([sample.time for sample in samples]) >= 0.0).all()
    with pytest.raises(BackendError, match="no new sample"):
        rig.bus.wait(samples[-1].at(CLOCK.now(), 1.0), 0.0)


def test_slow_rates_keep_their_mean(rig):
    start = rig.true_angles()
    began = rig.bus.read().cycle
    rate = 0.3 * Unit.VELOCITY
    samples = rig.fly([rate, 0.0, 0.0, 0.0], 0.4)
    CLOCK.sleep(0.05)
    seconds = (samples[-1].cycle - began) * rig.config.period
    assert (rig.true_angles() - start)[0] == pytest.approx(rate * seconds, abs=0.003)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_joints_stop_at_their_limits(make_rig, make_emulator, direction):
    """At full speed towards the limits of the URDF, which velocity mode does not know."""
    start = np.array(UPPER if direction > 0 else LOWER) - direction * 0.25
    rig = make_rig(make_emulator(angles=start))
    rig.bus.open()
    rig.fly([9.0 * direction] * 4, 0.5)
    bound = np.array(UPPER if direction > 0 else LOWER)
    assert ((bound - rig.true_angles()) * direction > 0.0).all()
    assert rig.true_angles() == pytest.approx(bound, abs=0.03)
    assert rig.true_rates() == pytest.approx(0.0, abs=1e-3)
    rig.fly([-0.5 * direction] * 4, 0.15)
    assert rig.true_rates() == pytest.approx(-0.5 * direction, abs=2 * Unit.VELOCITY)


def test_rates_are_cut_at_the_limits_of_joint_and_servo(make_rig, make_emulator):
    servos = [ServoSetup(1, dict(READY)), ServoSetup(2, READY | {"velocity limit": 60})]
    rig = make_rig(make_emulator(servos), ids=(1, 2), rate_limits=[1.0, 3.0])
    rig.bus.open()
    assert [finding.register for servo in rig.bus.servos for finding in servo.findings] == ["velocity limit"]
    rig.fly([3.0, 3.0], 0.3)
    assert rig.true_rates() == pytest.approx([1.0, 60 * Unit.VELOCITY], abs=Unit.VELOCITY)
    assert not rig.events()


def test_a_wound_up_servo_is_unwound_in_thought(make_rig, make_emulator):
    """A servo counts turns while it has power; the joint has none."""
    servo = ServoSetup(1, READY | {"homing offset": 4096})
    rig = make_rig(make_emulator([servo], angles=[0.4]), ids=(1,), homing_offsets=(4096,))
    rig.bus.open()
    assert rig.bus.read().angles == pytest.approx([0.4], abs=Unit.ANGLE)
    assert rig.bus.servos[0].turns == pytest.approx(-2 * np.pi)


# ---------------------------------------------------------------- commands


@pytest.mark.parametrize("rates", [[0.0, np.nan, 0.0, 0.0], [np.inf] * 4, [0.0] * 3, "fast", None])
def test_what_is_not_rates_stops_the_arm(rig, rates):
    rig.fly([0.5] * 4, 0.2)
    with pytest.raises(BackendError, match="not rates") as caught:
        rig.bus.command(rates)
    assert caught.value.field == "rates"
    cycle = rig.bus.read().cycle
    rig.until(lambda sample: sample.cycle > cycle + 1 and not sample.goals.any())


def test_reading_and_commanding_touch_no_device(rig):
    """With the bus held up, its user is not."""
    with rig.emulator.lock:
        for _ in range(50):
            rig.bus.read()
            rig.bus.command([0.1] * 4)
            CLOCK.sleep(0.002)
    rig.until(lambda sample: sample.fresh)


# ---------------------------------------------------------------- begin and end


def test_open_leaves_the_servos_ready(rig):
    assert rig.rows("torque enable") == [1] * 4
    assert rig.rows("bus watchdog") == [rig.config.watchdog_counts] * 4
    assert rig.rows("goal velocity") == [0] * 4
    assert [(s.servo_id, s.model, s.firmware) for s in rig.bus.servos] == [(k, 1000, 45) for k in (1, 2, 3, 4)]
    for misuse in (rig.bus.open, rig.bus.inspect, rig.bus.positions):
        with pytest.raises(BackendError, match="open already"):
            misuse()


@pytest.mark.parametrize("torque_off", [False, True])
def test_stop_leaves_the_servos_at_rest(make_rig, torque_off):
    rig = make_rig(torque_off_at_stop=torque_off)
    rig.bus.open()
    rig.fly([1.0] * 4, 0.2)
    assert (rig.true_rates() > 0.5).all()
    rig.bus.stop()
    assert rig.rows("goal velocity") == rig.rows("bus watchdog") == [0] * 4
    assert rig.rows("torque enable") == [int(not torque_off)] * 4
    CLOCK.sleep(0.2)
    assert rig.true_rates() == pytest.approx(0.0, abs=1e-3)
    with pytest.raises(BackendError, match="not open"):
        rig.bus.read()
    rig.bus.open()
    rig.fly([0.5] * 4, 0.1)
    assert follows(rig.bus.read())


def test_a_failing_user_leaves_the_servos_at_rest(make_rig):
    rig = make_rig()
    with pytest.raises(ZeroDivisionError), rig.bus:
        rig.fly([1.0] * 4, 0.2)
        _ = 1 / 0
    assert rig.rows("goal velocity") == [0] * 4
    assert "servo bus" not in [thread.name for thread in threading.enumerate()]


def test_open_after_a_program_that_was_killed(make_rig, make_emulator):
    """Torque on, moving, watchdog fired, answers switched off: what a crash may leave behind."""
    rig = make_rig(make_emulator())
    for servo_id in (1, 2, 3, 4):
        for name, value in (("torque enable", 1), ("status return level", 0), ("profile acceleration", 50), ("goal pwm", 200),
                            ("bus watchdog", 0xFF)):  # fmt: skip
            rig.set_row(servo_id, name, value)
    rig.bus.open()
    assert rig.rows("profile acceleration") == [0] * 4
    assert rig.rows("goal pwm") == [885] * 4
    rig.fly([0.5] * 4, 0.3)
    assert rig.true_rates() == pytest.approx(0.5, abs=2 * Unit.VELOCITY)


def test_the_port_belongs_to_one_program(rig, make_rig):
    second = make_rig(rig.emulator)
    with pytest.raises(BackendError, match="no other program"):
        second.bus.open()
    assert follows(rig.until(lambda sample: sample.fresh))


def test_what_cannot_be_opened_is_named(make_rig, tmp_path):
    plain = tmp_path / "file"
    plain.write_text("not a serial device")
    rig = make_rig()
    for path, words in ((plain, "cannot be opened"), (tmp_path / "missing", "no such serial device")):
        config = rig.config.__class__(str(path), LOWER, UPPER, [3.1] * 4)
        with pytest.raises(BackendError, match=words) as caught:
            rig.bus.__class__(config).open()
        assert caught.value.field == "servos.port"


def test_a_slow_usb_adapter_is_refused(make_rig, monkeypatch, tmp_path):
    from doorman.hardware.dynamixel import port

    rig = make_rig()
    timer = tmp_path / os.path.basename(os.path.realpath(rig.config.port)) / "latency_timer"
    timer.parent.mkdir()
    monkeypatch.setattr(port, "LATENCY_TIMERS", tmp_path)
    timer.write_text("16\n")
    with pytest.raises(BackendError, match="latency timer.*given '16 ms'"):
        rig.bus.open()
    timer.write_text("1\n")
    rig.bus.open()


def test_statistics_count_cycles(rig):
    rig.fly([0.0] * 4, 0.3)
    statistics = rig.bus.statistics
    assert statistics.cycles > 10
    assert statistics.period_median <= statistics.period_p999 <= statistics.period_max
