"""EEPROM settings that the adapter relies on: read, compared, and changed only on request."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from doorman.exceptions import BackendError
from doorman.hardware.dynamixel.faults import ServoEvent, ServoFault
from doorman.hardware.dynamixel.setup.talk import Servo
from doorman.hardware.dynamixel.wire import registers as reg
from doorman.hardware.dynamixel.wire.registers import VELOCITY_UNIT
from doorman.hardware.events import EventLog

TOLERATED_RETURN_DELAY = 25
"""Largest return delay time that the cycle has room for [2 µs]."""
MEASURED_SO = "zero and direction may depend on it: set it with DYNAMIXEL Wizard, then measure both again"
"""Why a setting on which the calibration rests is not written."""

SETTINGS = (
    reg.BAUD_RATE, reg.RETURN_DELAY, reg.DRIVE_MODE, reg.OPERATING_MODE, reg.SECONDARY_ID, reg.HOMING_OFFSET,
    reg.TEMPERATURE_LIMIT, reg.PWM_LIMIT, reg.CURRENT_LIMIT, reg.VELOCITY_LIMIT, reg.SHUTDOWN,
)  # fmt: skip
"""EEPROM registers that are verified; `STARTUP_CONFIGURATION` where the firmware has it."""


@dataclass(frozen=True)
class SettingFinding:
    """A setting of a servo that is not what the adapter relies on."""

    servo_id: int
    register: str
    given: int
    wanted: int
    why: str
    """What goes wrong otherwise."""
    blocking: bool
    """Whether the arm must not be used like this."""
    writable: bool = True
    """Whether `write_eeprom` may change it: not if that would cut the servo off, or turn the joint's zero or direction false."""

    def __str__(self) -> str:
        return f"servo {self.servo_id}: {self.register} is {self.given}, should be {self.wanted}: {self.why}"


def check_settings(servo: Servo) -> list[SettingFinding]:
    """Compare a servo's EEPROM with what the adapter relies on; changes nothing."""
    return [finding for finding in _findings(servo) if finding.given != finding.wanted]


def write_settings(servo: Servo, findings: list[SettingFinding], log: EventLog[ServoEvent]) -> None:
    """Change settings to what is wanted. Torque goes off for that, since it locks the EEPROM."""
    due = [finding for finding in findings if finding.writable]
    if not due:
        return
    servo.write(reg.TORQUE_ENABLE, reg.TORQUE_OFF)
    for finding in due:
        register = reg.REGISTERS[finding.register]
        servo.write(register, finding.wanted)
        text = f"{register.name} changed from {finding.given} to {finding.wanted}"
        log.write(ServoEvent(servo.now(), servo.id, ServoFault.NONE, True, text))
        if (now := servo.read(register)) != finding.wanted:
            raise BackendError("the servo did not keep a setting", field=f"servo {servo.id}: {register.name}",
                               given=now, allowed=str(finding.wanted))  # fmt: skip


def _findings(servo: Servo) -> Iterator[SettingFinding]:
    """Every setting with what is wanted, whether it differs or not."""
    config, joint = servo.config, servo.index < servo.config.n_joints
    given = {register: servo.read(register) for register in SETTINGS}

    def setting(
        register: reg.Register, wanted: int, why: str, blocking: bool = True, writable: bool = True
    ) -> SettingFinding:
        return SettingFinding(servo.id, register.name, given[register], wanted, why, blocking, writable)

    def at_least(register: reg.Register, wanted: int, why: str, writable: bool = False) -> SettingFinding:
        return setting(register, max(given[register], wanted), why, blocking=False, writable=writable)

    speed = reg.BAUD_CODES[config.baud_rate]
    yield setting(reg.BAUD_RATE, speed, "the bus runs at another speed", blocking=False, writable=False)
    slow = given[reg.RETURN_DELAY] > TOLERATED_RETURN_DELAY
    yield setting(reg.RETURN_DELAY, 0, "it delays every answer", blocking=slow)
    yield setting(reg.DRIVE_MODE, given[reg.DRIVE_MODE] & reg.REVERSED, "profile and torque switch differ")
    why = f"the servo counts and turns the other way round; {MEASURED_SO}"
    yield setting(reg.DRIVE_MODE, given[reg.DRIVE_MODE] & ~reg.REVERSED, why, writable=False)
    if joint:
        yield setting(reg.OPERATING_MODE, reg.VELOCITY_MODE, "the servo does not follow velocities")
    else:
        yield setting(reg.OPERATING_MODE, reg.CURRENT_MODE, "the gripper does not open by itself when commands stop")
    why = f"every joint angle is wrong by the difference; {MEASURED_SO}"
    yield setting(reg.HOMING_OFFSET, config.offsets[servo.index], why, writable=False)
    if given[reg.SECONDARY_ID] in config.ids and given[reg.SECONDARY_ID] != servo.id:
        yield setting(reg.SECONDARY_ID, 255, "the servo also obeys commands for another servo")
    if joint:
        needed = math.floor(float(config.limits[2][servo.index]) / VELOCITY_UNIT)
        yield at_least(reg.VELOCITY_LIMIT, needed, "the servo cannot turn as fast as the URDF's joint", writable=True)
    else:
        yield at_least(reg.CURRENT_LIMIT, reg.FACTORY_CURRENT_LIMITS[servo.model], "its grip is weaker")
    yield at_least(reg.PWM_LIMIT, reg.FULL_PWM, "its motor is weaker")
    shutdown = given[reg.SHUTDOWN] | int(reg.SHUTDOWN_NEEDED)
    yield setting(reg.SHUTDOWN, shutdown, "the servo does not protect itself against overload, shock or heat")
    hot = math.ceil(config.hot_temperature) + 1
    yield at_least(reg.TEMPERATURE_LIMIT, hot, "the servo shuts down before doorman stops a hot arm")
    if servo.firmware >= reg.STARTUP_FIRMWARE:
        given[reg.STARTUP_CONFIGURATION] = servo.read(reg.STARTUP_CONFIGURATION)
        yield setting(reg.STARTUP_CONFIGURATION, 0, "torque or goals come back by themselves after power-on")
