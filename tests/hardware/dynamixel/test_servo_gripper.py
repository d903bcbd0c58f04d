"""A gripper on the arm's bus: closed by a current, open by its spring as soon as anything has failed."""

from __future__ import annotations

import numpy as np
import pytest
from servo_rig import SLOW, follows, has, holds
from virtual_time import CLOCK

from doorman.exceptions import BackendError
from doorman.hardware.dynamixel import ServoFault
from doorman.hardware.dynamixel.registers import Unit
from doorman.rig.emulators.servos.bus import LaggingJoints
from doorman.rig.emulators.servos.unit import ENCODER, OVERLOAD, READY, READY_TO_GRIP, ServoSetup

ARM = SLOW[:3]
CLOSING = 0.6
OPEN, SHUT, CLOSED = 0.0, 0.8, 0.6


@pytest.fixture
def servos():
    return [ServoSetup(1), ServoSetup(2), ServoSetup(3), ServoSetup(4, dict(READY_TO_GRIP), spring=0.25)]


@pytest.fixture
def make_hand(make_rig, make_emulator):
    def make(servos, **fields):
        return make_rig(
            make_emulator(servos, plant=LaggingJoints(np.zeros(4), stops=(OPEN, SHUT))), gripper=True, **fields
        )

    return make


@pytest.fixture
def hand(make_hand, servos):
    rig = make_hand(servos)
    rig.bus.open()
    return rig


def grip(rig, current=CLOSING):
    rig.until(lambda sample: sample.angles[-1] > CLOSED, rates=(ARM, current))


def fingers(rig):
    return float(rig.true_angles()[-1])


def fired(rig, servo_id):
    """Let a servo's watchdog fire, and wait until the adapter has seen it."""
    rig.set_row(servo_id, "bus watchdog", 0xFF)
    rig.until(lambda _: bool(rig.began(ServoFault.WATCHDOG, servo_id=servo_id)), rates=(ARM, None))


def wait_until_open(rig, timeout=1.0):
    end = CLOCK.now() + timeout
    while fingers(rig) > 0.1:
        assert CLOCK.now() < end, f"still at {fingers(rig)}"
        CLOCK.sleep(0.01)


def test_it_closes_holds_and_opens(hand):
    grip(hand)
    hand.fly((ARM, None), 0.3)
    assert fingers(hand) == pytest.approx(SHUT, abs=1e-3), "None goes on with the last current"
    assert hand.bus.read().currents[-1] == pytest.approx(CLOSING, abs=0.003)
    hand.fly((ARM, 0.0), 1.0)
    assert fingers(hand) == pytest.approx(OPEN, abs=1e-3)


def test_direction_of_the_servo(make_hand, servos):
    servos[3].direction = -1
    rig = make_hand(servos, directions=(1, 1, 1, -1))
    rig.bus.open()
    grip(rig)
    assert rig.row(4, "goal current") < 0
    assert rig.bus.read().currents[-1] > 0.0


def test_currents_stay_below_the_servos_limit(make_hand, servos):
    servos[3].eeprom["current limit"] = 150
    rig = make_hand(servos)
    rig.bus.open()
    (finding,) = rig.bus.servos[3].findings
    assert str(finding) == "servo 4: current limit is 150, should be 648: its grip is weaker"
    assert not (finding.blocking or finding.writable)
    rig.fly((ARM, 1.0), 0.1)
    assert rig.row(4, "goal current") == 150


@pytest.mark.parametrize("failed", [2, 4])
def test_it_lets_go_when_a_servo_has_failed(hand, failed):
    grip(hand)
    hand.trip(failed, OVERLOAD)
    assert holds(hand.until(has(ServoFault.OVERLOAD), rates=(ARM, CLOSING)))
    hand.fly((ARM, CLOSING), 0.6)
    assert hand.true_rates()[:3] == pytest.approx(np.zeros(3), abs=2 * Unit.VELOCITY)
    if failed == 2:
        assert fingers(hand) > CLOSED, "the arm stops, the gripper follows"
    else:
        assert fingers(hand) < 0.1, "without torque the spring opens it"
    hand.fly((ARM, 0.0), 0.8)
    assert fingers(hand) < 0.1


def test_a_finger_whose_angle_is_lost_is_no_longer_driven(hand):
    """The servo goes on as if nothing had happened, and would close again: its current is taken, and its torque."""
    grip(hand)
    hand.trip(4, ENCODER)
    hand.until(has(ServoFault.ENCODER), rates=(ARM, None))
    hand.fly((ARM, None), 0.1)
    assert hand.row(4, "goal current") == 0
    wait_until_open(hand)


def test_it_holds_on_when_the_user_falls_silent(hand):
    grip(hand)
    hand.until(has(ServoFault.COMMAND_STALE))
    CLOCK.sleep(0.3)
    assert fingers(hand) > CLOSED
    assert hand.true_rates()[:3] == pytest.approx(np.zeros(3), abs=2 * Unit.VELOCITY)


def test_it_opens_when_the_adapter_fails_in_itself(hand, monkeypatch):
    """What stops the arm keeps the gripper's watchdog quiet."""
    grip(hand)

    def failing():
        raise RuntimeError("a mistake of ours")

    monkeypatch.setattr(hand.bus._cycle, "_faults", failing)
    wait_until_open(hand)


def test_it_opens_when_the_bus_is_stopped(hand):
    grip(hand)
    hand.bus.stop()
    wait_until_open(hand)


def test_it_opens_while_its_servo_restarts(hand):
    grip(hand)
    with hand.emulator.lock:
        hand.servo(4).reboot(CLOCK.now())
    wait_until_open(hand)


def test_a_gripper_in_velocity_mode_is_refused(make_hand, servos):
    servos[3].eeprom = dict(READY)
    rig = make_hand(servos)
    with pytest.raises(
        BackendError, match="servo 4: operating mode is 1, should be 0: the gripper does not open by itself"
    ):
        rig.bus.open()


def stays_open(rig):
    """However long the arm alone is commanded."""
    rig.fly((ARM, None), 0.3)
    assert fingers(rig) < 0.1
    assert rig.row(4, "goal current") == 0


def test_it_stays_open_after_its_watchdog_until_it_is_commanded_again(hand):
    grip(hand)
    fired(hand, 4)
    wait_until_open(hand)
    hand.until(follows, rates=(ARM, None))
    stays_open(hand)
    grip(hand)
    fired(hand, 2)
    hand.until(follows, rates=(ARM, None))
    hand.fly((ARM, None), 0.3)
    assert fingers(hand) > CLOSED, "it holds on when that of another servo fires"


def test_plugged_in_again_it_stays_open_until_it_is_commanded_again(make_rig, make_emulator, servos, tmp_path):
    plant = LaggingJoints(np.zeros(4), stops=(OPEN, SHUT))
    rig = make_rig(make_emulator(servos, plant=plant, link=tmp_path / "servos"), gripper=True)
    rig.bus.open()
    grip(rig)
    rig.emulator.unplug()
    wait_until_open(rig)
    assert rig.row(4, "present current") == 0
    rig.emulator.plug_in()
    rig.until(follows, rates=(ARM, None))
    stays_open(rig)
    grip(rig)


@pytest.mark.parametrize("failure", ["restarted", "internal"])
def test_recovered_it_stays_open_until_it_is_commanded_again(hand, monkeypatch, failure):
    grip(hand)
    if failure == "restarted":
        with hand.emulator.lock:
            hand.servo(4).reboot(CLOCK.now())
        hand.until(has(ServoFault.RESTARTED), rates=(ARM, None))
    else:
        with monkeypatch.context() as patch:
            patch.setattr(hand.bus._cycle, "_faults", lambda: 1 / 0)
            wait_until_open(hand)
    wait_until_open(hand)
    assert hand.bus.recover() == ()
    hand.until(follows, rates=(ARM, None))
    stays_open(hand)
    grip(hand)


@pytest.mark.parametrize("current", [np.nan, "much", (1.0, 2.0), -2.1])
def test_what_is_no_current_stops_the_arm_and_holds_on(hand, current):
    grip(hand)
    with pytest.raises(BackendError, match="grip") as caught:
        hand.bus.command(ARM, current)
    assert caught.value.field == "grip"
    hand.fly(([0.0] * 3, None), 0.1)
    assert fingers(hand) > CLOSED


def test_an_arm_without_joints_is_refused(make_rig):
    with pytest.raises(BackendError, match="servos.ids"):
        make_rig(ids=(1,), gripper=True)
