"""Careful talk with one servo while it is set up, and the EEPROM settings that the adapter relies on."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from doorman.background import EventLog
from doorman.exceptions import BackendError
from doorman.hardware.dynamixel import registers as reg
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.faults import ServoEvent, ServoFault
from doorman.hardware.dynamixel.link import Link, Reply
from doorman.hardware.dynamixel.registers import Unit

ATTEMPTS = 8
"""Attempts before an instruction counts as failed."""
REFUSALS = {
    1: "it failed to carry it out",
    2: "it does not know the instruction",
    3: "the instruction arrived damaged",
    4: "the value is out of range, or its bus watchdog has fired",
    5: "the value has the wrong length",
    6: "the value is beyond a limit of the servo",
    7: "the register cannot be accessed, or is locked while torque is on",
}
_DAMAGED_ON_THE_WAY = 3


class Servo:
    def __init__(
        self, link: Link, config: ServoConfig, index: int, deadline: float, between: Callable[[], None] = lambda: None
    ) -> None:
        self.id, self.config, self.index = config.ids[index], config, index
        self.model = self.firmware = 0
        self.is_joint = index < config.n_joints  # else the gripper
        self.goal = reg.GOAL_VELOCITY if self.is_joint else reg.GOAL_CURRENT
        self._link, self._deadline, self._between = link, deadline, between

    def identify(self, models: tuple[int, ...] = ()) -> None:
        """Ask who answers, one of some models; by default of those that are configured."""
        data, models = self._insist("ping", lambda: self._link.ping(self.id)).data, models or self.config.models
        self.model, self.firmware = int.from_bytes(data[:2], "little"), data[2]
        if self.model not in models:
            names = ", ".join(f"{number} {reg.MODELS.get(number, '')}".strip() for number in models)
            raise self.error("wrong model", self.model, names)
        if self.firmware < reg.OLDEST_FIRMWARE:
            raise self.error("the firmware is too old for the bus watchdog", self.firmware,
                             f">= {reg.OLDEST_FIRMWARE}; DYNAMIXEL Wizard updates it")  # fmt: skip

    def make_answer(self) -> None:
        """Identify the servo and let it answer everything, in RAM: below that level, reads stay unanswered."""
        self.identify()
        self._link.write(self.id, reg.STATUS_RETURN_LEVEL, reg.ANSWER_ALL)

    def error(self, message: str, given: object = None, allowed: str | None = None, of: str = "") -> BackendError:
        return BackendError(message, field=f"servo {self.id}{of}", given=given, allowed=allowed)

    def event(self, text: str) -> ServoEvent:
        return ServoEvent(self._link.now(), self.id, ServoFault.NONE, True, text)

    def read(self, register: reg.Register) -> int:
        return register.decode(self._insist(f"read {register.name}", lambda: self._link.read(self.id, register)).data)

    def write(self, register: reg.Register, value: int) -> None:
        self._insist(f"write {register.name}", lambda: self._link.write(self.id, register, value))

    def ensure(self, register: reg.Register, value: int) -> None:
        if self.read(register) != value:
            self.write(register, value)

    def clear_watchdog(self) -> None:
        """Clear the bus watchdog and zero the goal in one go: before, the servo refuses it; after, it may pursue the old one."""
        self._between()
        self._link.clear_watchdog(self.id, self.goal)
        self.write(reg.BUS_WATCHDOG, reg.WATCHDOG_OFF)

    def reboot(self) -> None:
        """Restart a servo that has shut down, and wait until it answers again."""
        # It may go on answering for a while before it restarts: it has done so once it was silent, or shows no error any more.
        heard, silent, patience = self._link.reboot(self.id).ok, False, self.config.boot_timeout
        end = min(self._link.now() + patience, self._deadline)
        while True:
            self._between()
            answer = self._link.ping(self.id)
            if answer.ok and (silent or not answer.alert):
                return
            silent = silent or answer.fault is ServoFault.TIMEOUT
            if answer.ok and not heard:
                heard = self._link.reboot(self.id).ok
            if self._link.now() > end:
                raise self.error("the servo did not come back after a reboot", f"{patience:g} s", "an answer to ping")

    def _insist(self, what: str, attempt: Callable[[], Reply]) -> Reply:
        tries = 0
        while True:
            self._between()
            reply, tries = attempt(), tries + 1
            if reply.ok:
                return reply
            refused = reply.fault is ServoFault.REFUSED and reply.error_number != _DAMAGED_ON_THE_WAY
            if refused or tries == ATTEMPTS or self._link.now() > self._deadline:
                break
        if reply.fault is ServoFault.REFUSED:
            why = REFUSALS.get(reply.error_number, f"error {reply.error_number}")
            raise self.error(f"the servo refuses to {what}: {why}")
        words = "no answer" if reply.fault is ServoFault.TIMEOUT else "damaged answer"
        raise self.error(
            f"{words} to {what}", None, "a servo of this id, powered, at this baud rate, with sound cables"
        )


TOLERATED_RETURN_DELAY = 25
"""Largest return delay time that the cycle has room for [2 µs]."""
MEASURED_SO = "zero and direction may depend on it: set it with DYNAMIXEL Wizard, then measure both again"
"""Why a setting on which the calibration rests is not written."""

SETTINGS = {register.name: register for register in (
    reg.BAUD_RATE, reg.RETURN_DELAY, reg.DRIVE_MODE, reg.OPERATING_MODE, reg.SECONDARY_ID, reg.HOMING_OFFSET,
    reg.TEMPERATURE_LIMIT, reg.PWM_LIMIT, reg.CURRENT_LIMIT, reg.VELOCITY_LIMIT, reg.STARTUP_CONFIGURATION, reg.SHUTDOWN,
)}  # fmt: skip
"""EEPROM registers that are verified, by name; `STARTUP_CONFIGURATION` where the firmware has it."""


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
    known = [
        register for register in SETTINGS.values()
        if register is not reg.STARTUP_CONFIGURATION or servo.firmware >= reg.STARTUP_FIRMWARE
    ]  # fmt: skip
    given = {register: servo.read(register) for register in known}
    return [
        SettingFinding(servo.id, register.name, given[register], wanted, why, blocking, writable)
        for register, wanted, why, blocking, writable in _wanted(servo, given)
        if register in given and given[register] != wanted
    ]


def write_settings(servo: Servo, findings: list[SettingFinding], log: EventLog[ServoEvent]) -> None:
    """Change settings to what is wanted. Torque goes off for that, since it locks the EEPROM."""
    due = [finding for finding in findings if finding.writable]
    if due:
        servo.write(reg.TORQUE_ENABLE, reg.TORQUE_OFF)
    for finding in due:
        register = SETTINGS[finding.register]
        servo.write(register, finding.wanted)
        log.write(servo.event(f"{register.name} changed from {finding.given} to {finding.wanted}"))
        if (now := servo.read(register)) != finding.wanted:
            raise servo.error("the servo did not keep a setting", now, str(finding.wanted), f": {register.name}")


def _wanted(servo: Servo, given: dict[reg.Register, int]) -> list[tuple[reg.Register, int, str, bool, bool]]:
    """What every setting should be, what goes wrong otherwise, whether that keeps the arm from being used, and may be written."""
    config, index = servo.config, servo.index

    def at_least(register: reg.Register, wanted: int, why: str) -> tuple[reg.Register, int, str, bool, bool]:
        writable = register is reg.VELOCITY_LIMIT
        return register, max(given[register], wanted), why, False, writable

    drive, secondary = given[reg.DRIVE_MODE], given[reg.SECONDARY_ID]
    obeys_another = secondary in config.ids and secondary != servo.id
    if servo.is_joint:
        mode, why_mode = reg.VELOCITY_MODE, "the servo does not follow velocities"
        needed = math.floor(float(config.limits.rates[index]) / Unit.VELOCITY)
        strength = at_least(reg.VELOCITY_LIMIT, needed, "the servo cannot turn as fast as the URDF's joint")
    else:
        mode, why_mode = reg.CURRENT_MODE, "the gripper does not open by itself when commands stop"
        strength = at_least(reg.CURRENT_LIMIT, reg.FACTORY_CURRENT_LIMITS[servo.model], "its grip is weaker")
    return [
        (reg.BAUD_RATE, reg.BAUD_CODES[config.baud_rate], "the bus runs at another speed", False, False),
        (reg.RETURN_DELAY, 0, "it delays every answer", given[reg.RETURN_DELAY] > TOLERATED_RETURN_DELAY, True),
        (reg.DRIVE_MODE, drive & reg.REVERSED, "profile and torque switch differ", True, True),
        (reg.DRIVE_MODE, drive & ~reg.REVERSED, f"the servo counts and turns the other way round; {MEASURED_SO}", True, False),
        (reg.OPERATING_MODE, mode, why_mode, True, True),
        (reg.HOMING_OFFSET, config.offsets[index], f"every joint angle is wrong by the difference; {MEASURED_SO}", True, False),
        (reg.SECONDARY_ID, 255 if obeys_another else secondary, "the servo also obeys commands for another servo", True, True),
        strength,
        at_least(reg.PWM_LIMIT, reg.FULL_PWM, "its motor is weaker"),
        (reg.SHUTDOWN, given[reg.SHUTDOWN] | int(reg.SHUTDOWN_NEEDED),
         "the servo does not protect itself against overload, shock or heat", True, True),
        at_least(reg.TEMPERATURE_LIMIT, math.ceil(config.hot_temperature) + 1,
                 "the servo shuts down before doorman stops a hot arm"),
        (reg.STARTUP_CONFIGURATION, 0, "torque or goals come back by themselves after power-on", True, True),
    ]  # fmt: skip
