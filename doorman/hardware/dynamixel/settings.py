"""Careful talk with one servo while it is set up, and the EEPROM settings that the adapter relies on."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from doorman.background import EventLog
from doorman.exceptions import BackendError
from doorman.hardware.dynamixel import registers as reg
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.faults import ServoEvent, ServoFault
from doorman.hardware.dynamixel.link import Link, Outcome, Reply
from doorman.hardware.dynamixel.registers import VELOCITY_UNIT

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
        self.id, self.config, self.index, self.deadline = config.ids[index], config, index, deadline
        self.model = self.firmware = 0
        self.goal = reg.GOAL_VELOCITY if index < config.n_joints else reg.GOAL_CURRENT
        self._link, self._between = link, between

    def identify(self, models: tuple[int, ...] = ()) -> None:
        """Ask who answers, one of some models; by default of those that are configured."""
        data, models = self._insist("ping", lambda: self._link.ping(self.id)).data, models or self.config.models
        self.model, self.firmware = int.from_bytes(data[:2], "little"), data[2]
        if self.model not in models:
            names = ", ".join(f"{number} {reg.MODELS.get(number, '')}".strip() for number in models)
            raise BackendError("wrong model", field=f"servo {self.id}", given=self.model, allowed=names)
        if self.firmware < reg.OLDEST_FIRMWARE:
            raise BackendError("the firmware is too old for the bus watchdog", field=f"servo {self.id}", given=self.firmware,
                               allowed=f">= {reg.OLDEST_FIRMWARE}; DYNAMIXEL Wizard updates it")  # fmt: skip

    def make_answer(self) -> None:
        """Identify the servo and let it answer everything, in RAM: below that level, reads stay unanswered."""
        self.identify()
        register = reg.STATUS_RETURN_LEVEL
        self._link.write(self.id, register.address, register.encode(reg.ANSWER_ALL))

    def now(self) -> float:
        return self._link.now()

    def read(self, register: reg.Register) -> int:
        return register.decode(self.read_bytes(register.address, register.size, register.name))

    def read_bytes(self, address: int, length: int, name: str) -> bytes:
        return self._insist(f"read {name}", lambda: self._link.read(self.id, address, length)).data

    def write(self, register: reg.Register, value: int) -> None:
        self.write_bytes(register.address, register.encode(value), register.name)

    def write_bytes(self, address: int, data: bytes, name: str) -> None:
        self._insist(f"write {name}", lambda: self._link.write(self.id, address, data))

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
        end = min(self._link.now() + patience, self.deadline)
        while True:
            self._between()
            answer = self._link.ping(self.id)
            if answer.ok and (silent or not answer.alert):
                return
            silent = silent or answer.outcome is Outcome.TIMEOUT
            if answer.ok and not heard:
                heard = self._link.reboot(self.id).ok
            if self._link.now() > end:
                raise BackendError("the servo did not come back after a reboot", field=f"servo {self.id}",
                                   given=f"{patience:g} s", allowed="an answer to ping")  # fmt: skip

    def _insist(self, what: str, attempt: Callable[[], Reply]) -> Reply:
        tries = 0
        while True:
            self._between()
            reply, tries = attempt(), tries + 1
            refused = reply.outcome is Outcome.REFUSED and reply.error_number != _DAMAGED_ON_THE_WAY
            if reply.ok or refused or tries == ATTEMPTS or self._link.now() > self.deadline:
                break
        if reply.ok:
            return reply
        if reply.outcome is Outcome.REFUSED:
            why = REFUSALS.get(reply.error_number, f"error {reply.error_number}")
            raise BackendError(f"the servo refuses to {what}: {why}", field=f"servo {self.id}")
        raise BackendError(f"{reply.outcome.value} to {what}", field=f"servo {self.id}",
                           allowed="a servo of this id, powered, at this baud rate, with sound cables")  # fmt: skip


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
        needed = math.floor(float(config.limits.rates[servo.index]) / VELOCITY_UNIT)
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
