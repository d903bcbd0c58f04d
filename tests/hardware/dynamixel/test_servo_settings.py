"""EEPROM settings: found, named, changed only on request."""

from __future__ import annotations

import math

import pytest

from doorman.exceptions import BackendError
from doorman.hardware.dynamixel import ServoFault
from doorman.rig.emulators.servos import emulator as servos
from doorman.rig.emulators.servos.unit import OVERHEATING, OVERLOAD, READY, ServoSetup

WRONG = [
    ("operating mode", 3, 1),
    ("drive mode", 8, 0),
    ("return delay time", 250, 0),
    ("shutdown", 4, 52),
    ("secondary id", 2, 255),
    ("startup configuration", 1, 0),
]
"""Register, what it holds, what is wanted: each keeps the arm from being used."""
CALIBRATED = [("drive mode", 1, 0), ("homing offset", -17, 0)]
"""The same, but zeros and directions may have been measured with it: never written."""
QUESTIONABLE = [
    ("return delay time", 5, 0),
    ("velocity limit", 100, 129),
    ("temperature limit", 70, 71),
    ("pwm limit", 600, 885),
]
"""As those before, but the arm may be used."""


@pytest.fixture
def with_setting(make_rig, make_emulator):
    """Two servos, the first with one odd setting."""

    def make(name, value, **fields):
        setups = [ServoSetup(1, READY | {name: value}), ServoSetup(2)]
        return make_rig(make_emulator(setups), ids=(1, 2), **fields)

    return make


@pytest.mark.parametrize(("name", "given", "wanted"), WRONG + CALIBRATED)
def test_wrong_settings_are_refused_and_not_changed(with_setting, name, given, wanted):
    rig = with_setting(name, given)
    (finding,) = rig.bus.inspect()
    assert (finding.servo_id, finding.register, finding.given, finding.wanted) == (1, name, given, wanted)
    assert finding.blocking
    with pytest.raises(BackendError, match=f"servo 1: {name} is {given}, should be {wanted}: ") as caught:
        rig.bus.open()
    assert "write_eeprom" in caught.value.allowed
    assert rig.row(1, name) == given
    assert rig.row(2, "torque enable") == 0


@pytest.mark.parametrize(("name", "given", "wanted"), WRONG)
def test_settings_are_changed_on_request(with_setting, name, given, wanted):
    rig = with_setting(name, given, write_eeprom=True)
    rig.set_row(1, "torque enable", 1)  # as an earlier program left it; EEPROM is locked then
    rig.bus.open()
    assert rig.row(1, name) == wanted
    assert rig.bus.servos[0].findings == ()
    assert rig.row(1, "torque enable") == 1
    assert [str(event) for event in rig.events()] == [f"servo 1: {name} changed from {given} to {wanted}"]


@pytest.mark.parametrize(("name", "given", "wanted"), CALIBRATED)
def test_what_the_calibration_rests_on_is_never_written(with_setting, name, given, wanted):
    """Zero and direction that were measured with it would be wrong from then on, and nothing would say so."""
    rig = with_setting(name, given, write_eeprom=True)
    with pytest.raises(BackendError, match=f"{name} is {given}, should be {wanted}: .*measure both again") as caught:
        rig.bus.open()
    assert f"but never {name}" in caught.value.allowed
    assert rig.row(1, name) == given
    assert rig.events() == []


def test_other_bits_of_the_drive_mode_are_written_without_the_reversal(with_setting):
    rig = with_setting("drive mode", 9, write_eeprom=True)
    with pytest.raises(
        BackendError, match="drive mode is 1, should be 0: the servo counts and turns the other way round"
    ):
        rig.bus.open()
    assert rig.row(1, "drive mode") == 1
    assert [event.text for event in rig.events()] == ["drive mode changed from 9 to 1"]


@pytest.mark.parametrize(("name", "given", "wanted"), QUESTIONABLE)
def test_questionable_settings_are_reported(with_setting, name, given, wanted):
    rig = with_setting(name, given)
    rig.bus.open()
    (finding,) = rig.bus.servos[0].findings
    assert (finding.register, finding.given, finding.wanted, finding.blocking) == (name, given, wanted, False)
    assert str(finding).startswith(f"servo 1: {name} is {given}, should be {wanted}: ")
    assert rig.row(1, name) == given


def test_what_would_cut_the_servo_off_is_never_written(with_setting, monkeypatch):
    monkeypatch.setattr(servos, "LINE_RATES", {})  # as if a bridge on the way spoke to the servos at their rate
    rig = with_setting("baud rate", 1, write_eeprom=True)
    rig.bus.open()
    assert rig.row(1, "baud rate") == 1
    (finding,) = rig.bus.servos[0].findings
    assert (finding.register, finding.given, finding.wanted, finding.blocking) == ("baud rate", 1, 3, False)
    assert str(finding).startswith("servo 1: baud rate is 1, should be 3: ")


def test_inspection_changes_nothing(with_setting):
    rig = with_setting("operating mode", 3)
    with rig.emulator.lock:
        before = bytes(rig.servo(1).memory.read(0, 14)[1])
    rig.bus.inspect()
    with rig.emulator.lock:
        assert bytes(rig.servo(1).memory.read(0, 14)[1]) == before
    assert [rig.row(1, name) for name in ("torque enable", "bus watchdog", "goal velocity")] == [0, 0, 0]


def test_a_new_servo_needs_all_of_its_settings(make_rig, make_emulator):
    """As it comes out of the box, but for its baud rate."""
    new = ServoSetup(1, {"baud rate": 3})
    rig = make_rig(make_emulator([new]), ids=(1,))
    assert [finding.register for finding in rig.bus.inspect()] == ["return delay time", "operating mode"]
    rig.bus.stop()
    again = make_rig(rig.emulator, ids=(1,), write_eeprom=True)
    again.bus.open()
    assert again.bus.servos[0].findings == ()


def test_what_another_program_left_behind_is_set_up_again(with_setting):
    """Torque that is on does not keep the telemetry from being gathered; gains are as after power-on."""
    rig = with_setting("torque enable", 1)
    rig.set_row(1, "velocity p gain", 7)
    rig.set_row(1, "velocity i gain", 0)
    assert rig.row(1, "indirect address 168") == 224
    rig.bus.open()
    assert rig.row(1, "indirect address 168") != 224
    assert rig.row(1, "torque enable") == 1
    assert [rig.row(1, f"velocity {which} gain") for which in "pi"] == [100, 1920]


def test_present_positions_without_torque(make_rig, make_emulator):
    """As the zeros are measured: nothing but positions is asked for, and the joints may be turned by hand."""
    rig = make_rig(make_emulator([1, 2], angles=[0.0, math.pi / 2]), ids=(1, 2))
    assert rig.bus.positions() == (2048, 3072)
    assert [rig.row(servo_id, "torque enable") for servo_id in (1, 2)] == [0, 0]


def test_old_firmware_has_no_startup_configuration(with_setting):
    rig = with_setting("firmware version", 44)
    assert rig.bus.inspect() == ()
    rig.bus.open()


# ---------------------------------------------------------------- who answers


def test_wrong_model_is_refused_before_anything_is_written(with_setting):
    rig = with_setting("model number", 1020)
    with pytest.raises(BackendError, match="servo 1: wrong model .given 1020; allowed: 1000 XH430-W350"):
        rig.bus.open()
    with pytest.raises(BackendError, match="wrong model"):
        rig.bus.inspect()
    assert rig.rows("torque enable") == [0, 0]
    assert rig.rows("indirect address 168") == [224, 224]


def trip(bits):
    return lambda servo: servo.trip(bits)


@pytest.mark.parametrize(
    ("setups", "spoil", "words"),
    [
        ([ServoSetup(1, READY | {"firmware version": 37})], None,
         "servo 1: the firmware is too old for the bus watchdog .given 37; allowed: >= 38"),
        ([ServoSetup(1, READY | {"baud rate": 1})], None, "servo 1: no answer to ping .*at this baud rate"),
        ([ServoSetup(7)], None, "servo 1: no answer to ping"),
        ([ServoSetup(1)], lambda servo: servo.memory.set("present temperature", 85),
         "servo 1: the servo is too hot to be rebooted .given '85 °C'; allowed: below 70 °C"),
        ([ServoSetup(1)], lambda servo: setattr(servo, "lasting_errors", OVERHEATING),
         "servo 1: a hardware error persists after a reboot"),
        ([ServoSetup(1, boot_time=60.0)], trip(OVERLOAD), "servo 1: the servo did not come back after a reboot"),
    ],
    ids=["firmware", "baud rate", "missing", "hot", "lasting error", "no boot"],
)  # fmt: skip
def test_servos_that_cannot_be_made_ready_are_named(make_rig, make_emulator, setups, spoil, words):
    rig = make_rig(make_emulator([*setups, ServoSetup(2)]), ids=(1, 2), boot_timeout=0.2)
    if spoil is not None:
        with rig.emulator.lock:
            spoil(rig.servo(1))
    with pytest.raises(BackendError, match=words):
        rig.bus.open()
    assert rig.row(2, "torque enable") == 0


def test_a_noisy_bus_is_opened_all_the_same(make_rig):
    rig = make_rig()
    rig.emulator.faults.corrupt = 0.05
    rig.emulator.faults.noise = 0.1
    rig.emulator.faults.deafness = 0.05
    rig.bus.open()
    assert [servo.model for servo in rig.bus.servos] == [1000] * 4


@pytest.mark.parametrize("lost", [0, 1, 2])
def test_a_servo_that_shut_down_is_rebooted_at_open(make_rig, monkeypatch, lost):
    """A reboot that it does not hear is asked for again: it goes on answering then."""
    rig = make_rig()
    servo = rig.servo(2)
    real, asked = servo.execute, []

    def deaf(at, instruction):
        if instruction.code == 0x08:
            asked.append(instruction)
            if len(asked) <= lost:
                return None
        return real(at, instruction)

    with rig.emulator.lock:
        servo.trip(OVERLOAD)
        monkeypatch.setattr(servo, "execute", deaf)
    rig.bus.open()
    assert len(asked) == lost + 1
    assert (rig.row(2, "hardware error status"), rig.row(2, "torque enable")) == (0, 1)
    assert rig.bus.read().fault is ServoFault.NONE


def test_a_servo_that_answers_on_before_it_reboots(make_rig, make_emulator):
    """Its answers do not say that it has."""
    rig = make_rig(make_emulator([ServoSetup(1), ServoSetup(2, reboot_delay=0.08)]), ids=(1, 2))
    rig.trip(2, OVERLOAD)
    rig.bus.open()
    assert rig.row(2, "hardware error status") == 0
    assert rig.bus.read().fault is ServoFault.NONE
