"""EEPROM settings that the adapter relies on: read, compared, and changed only on request."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from doorman.exceptions import BackendError
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.faults import ServoEvent, ServoFault
from doorman.hardware.dynamixel.setup.talk import Servo
from doorman.hardware.dynamixel.wire.registers import (
    BAUD_CODES,
    BAUD_RATE,
    CURRENT_LIMIT,
    CURRENT_MODE,
    DRIVE_MODE,
    FACTORY_CURRENT_LIMITS,
    FULL_PWM,
    HOMING_OFFSET,
    OPERATING_MODE,
    PWM_LIMIT,
    RETURN_DELAY,
    REVERSED,
    SECONDARY_ID,
    SHUTDOWN,
    SHUTDOWN_NEEDED,
    STARTUP_CONFIGURATION,
    STARTUP_FIRMWARE,
    TEMPERATURE_LIMIT,
    TORQUE_ENABLE,
    TORQUE_OFF,
    VELOCITY_LIMIT,
    VELOCITY_MODE,
    Register,
)
from doorman.hardware.dynamixel.wire.units import VELOCITY_UNIT
from doorman.hardware.events import EventLog

TOLERATED_RETURN_DELAY = 25
"""Largest return delay time that the cycle has room for [2 µs]."""
MEASURED_SO = "zero and direction may depend on it: set it with DYNAMIXEL Wizard, then measure both again"
"""Why a setting on which the calibration rests is not written."""

SETTINGS = {
    register.name: register
    for register in (
        BAUD_RATE, RETURN_DELAY, DRIVE_MODE, OPERATING_MODE, SECONDARY_ID, HOMING_OFFSET, TEMPERATURE_LIMIT,
        PWM_LIMIT, CURRENT_LIMIT, VELOCITY_LIMIT, STARTUP_CONFIGURATION, SHUTDOWN,
    )
}  # fmt: skip
"""EEPROM registers that are verified, by name."""


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
        """Render `servo 2: operating mode is 3, should be 1: …`."""
        return f"servo {self.servo_id}: {self.register} is {self.given}, should be {self.wanted}: {self.why}"


def check_settings(servo: Servo, index: int, config: ServoConfig) -> list[SettingFinding]:
    """Compare a servo's EEPROM with what the adapter relies on; changes nothing."""
    return [finding for finding in _findings(servo, index, config) if finding.given != finding.wanted]


def write_settings(servo: Servo, findings: list[SettingFinding], log: EventLog[ServoEvent]) -> None:
    """Change settings to what is wanted. Torque goes off for that, since it locks the EEPROM."""
    due = [finding for finding in findings if finding.writable]
    if not due:
        return
    servo.write(TORQUE_ENABLE, TORQUE_OFF)
    for finding in due:
        register = SETTINGS[finding.register]
        servo.write(register, finding.wanted)
        text = f"{register.name} changed from {finding.given} to {finding.wanted}"
        log.write(ServoEvent(servo.now(), servo.id, ServoFault.NONE, True, text))
        if (now := servo.read(register)) != finding.wanted:
            raise BackendError("the servo did not keep a setting", field=f"servo {servo.id}: {register.name}",
                               given=now, allowed=str(finding.wanted))  # fmt: skip


def _findings(servo: Servo, index: int, config: ServoConfig) -> Iterator[SettingFinding]:
    """Every setting with what is wanted, whether it differs or not."""
    read = servo.read

    def setting(
        register: Register, wanted: int, why: str, blocking: bool = True, writable: bool = True
    ) -> SettingFinding:
        return SettingFinding(servo.id, register.name, given[register], wanted, why, blocking, writable)

    given = {register: read(register) for register in SETTINGS.values() if register is not STARTUP_CONFIGURATION}
    yield setting(
        BAUD_RATE, BAUD_CODES[config.baud_rate], "the bus runs at another speed", blocking=False, writable=False
    )
    yield setting(RETURN_DELAY, 0, "it delays every answer", blocking=given[RETURN_DELAY] > TOLERATED_RETURN_DELAY)
    yield setting(DRIVE_MODE, given[DRIVE_MODE] & REVERSED, "profile and torque switch differ")
    why = f"the servo counts and turns the other way round; {MEASURED_SO}"
    yield setting(DRIVE_MODE, given[DRIVE_MODE] & ~REVERSED, why, writable=False)
    if index < config.n_joints:
        yield setting(OPERATING_MODE, VELOCITY_MODE, "the servo does not follow velocities")
    else:
        yield setting(OPERATING_MODE, CURRENT_MODE, "the gripper does not open by itself when commands stop")
    why = f"every joint angle is wrong by the difference; {MEASURED_SO}"
    yield setting(HOMING_OFFSET, config.offsets[index], why, writable=False)
    if given[SECONDARY_ID] in config.ids and given[SECONDARY_ID] != servo.id:
        yield setting(SECONDARY_ID, 255, "the servo also obeys commands for another servo")
    if index < config.n_joints:
        needed = math.floor(float(config.limits[2][index]) / VELOCITY_UNIT)
        yield setting(VELOCITY_LIMIT, max(given[VELOCITY_LIMIT], needed), "the servo cannot turn as fast as the URDF's joint",
                      blocking=False)  # fmt: skip
    else:
        yield setting(CURRENT_LIMIT, max(given[CURRENT_LIMIT], FACTORY_CURRENT_LIMITS[servo.model]), "its grip is weaker",
                      blocking=False, writable=False)  # fmt: skip
    yield setting(PWM_LIMIT, max(given[PWM_LIMIT], FULL_PWM), "its motor is weaker", blocking=False, writable=False)
    shutdown = given[SHUTDOWN] | int(SHUTDOWN_NEEDED)
    yield setting(SHUTDOWN, shutdown, "the servo does not protect itself against overload, shock or heat")
    hot = math.ceil(config.hot_temperature) + 1
    yield setting(TEMPERATURE_LIMIT, max(given[TEMPERATURE_LIMIT], hot), "the servo shuts down before doorman stops a hot arm",
                  blocking=False, writable=False)  # fmt: skip
    if servo.firmware >= STARTUP_FIRMWARE:
        given[STARTUP_CONFIGURATION] = read(STARTUP_CONFIGURATION)
        yield setting(STARTUP_CONFIGURATION, 0, "torque or goals come back by themselves after power-on")
