"""From a servo in any state to one that follows velocities under a bus watchdog, and back to rest."""

from __future__ import annotations

from dataclasses import dataclass

from doorman.exceptions import BackendError
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.faults import ServoEvent
from doorman.hardware.dynamixel.setup.settings import SettingFinding, check_settings, write_settings
from doorman.hardware.dynamixel.setup.talk import Servo
from doorman.hardware.dynamixel.wire.registers import (
    ANSWER_ALL,
    BUS_WATCHDOG,
    CURRENT_LIMIT,
    FACTORY_GAINS,
    GOAL_CURRENT,
    GOAL_PWM,
    GOAL_VELOCITY,
    HARDWARE_ERROR,
    INDIRECT_ADDRESS,
    PRESENT_POSITION,
    PRESENT_TEMPERATURE,
    PROFILE_ACCELERATION,
    PWM_LIMIT,
    SHUTDOWN,
    STATUS_RETURN_LEVEL,
    TORQUE_ENABLE,
    TORQUE_OFF,
    TORQUE_ON,
    VELOCITY_LIMIT,
    WATCHDOG_FIRED,
    WATCHDOG_OFF,
    HardwareError,
    Register,
)
from doorman.hardware.dynamixel.wire.telemetry import MAPPING
from doorman.hardware.dynamixel.wire.units import CURRENT_UNITS, joint_angle, whole_turns
from doorman.hardware.events import EventLog

VOLTAGE_ONLY = int(HardwareError.VOLTAGE)


@dataclass(frozen=True)
class ReadyServo:
    """What was learnt about a servo that is ready."""

    servo_id: int
    model: int
    firmware: int
    velocity_limit: int
    """Largest goal velocity that it accepts, as counts."""
    current_limit: int
    """Largest goal current that it accepts, as counts."""
    turns: float
    """To add to its angle so that it lies between the joint's limits [rad]."""
    findings: tuple[SettingFinding, ...]
    """Settings that differ and were not changed."""

    @property
    def current_unit(self) -> float:
        """One count of a current [A]."""
        return CURRENT_UNITS[self.model]


def inspect(servo: Servo, index: int, config: ServoConfig) -> list[SettingFinding]:
    """Identify a servo and compare its settings; changes nothing but what lets it answer."""
    servo.identify(config.models)
    servo.write_unanswered(STATUS_RETURN_LEVEL, ANSWER_ALL)  # in RAM; below it, reads stay unanswered
    return check_settings(servo, index, config)


def position(servo: Servo, config: ServoConfig) -> int:
    """Present position of a servo [tick]; changes nothing but what lets it answer."""
    servo.identify(config.models)
    servo.write_unanswered(STATUS_RETURN_LEVEL, ANSWER_ALL)
    return servo.read(PRESENT_POSITION)


def commission(
    servo: Servo, index: int, config: ServoConfig, log: EventLog[ServoEvent], *, reboot: bool, write_eeprom: bool
) -> ReadyServo:
    """Make a servo ready: identified, settings checked, telemetry block gathered, standing still with torque on."""
    # The bus watchdog is left off, since the next instruction may take a while: `arm_watchdog` sets it.
    findings = inspect(servo, index, config)
    _clear_errors(servo, config, reboot)
    if write_eeprom and findings:
        write_settings(servo, findings, log)
        findings = check_settings(servo, index, config)
    blocking = [finding for finding in findings if finding.blocking]
    if blocking:
        kept = ", ".join(finding.register for finding in blocking if not finding.writable)
        how = "write_eeprom (doorman fly --write-eeprom) changes them" + (f", but never {kept}" if kept else "")
        raise BackendError("; ".join(str(finding) for finding in blocking), field="servos",
                           allowed=f"settings as above; {how}")  # fmt: skip
    _stand_still(servo, index, config)
    _gather_telemetry(servo)
    servo.write(TORQUE_ENABLE, TORQUE_ON)
    if servo.read(TORQUE_ENABLE) != TORQUE_ON:
        raise BackendError(
            "the torque cannot be switched on", field=f"servo {servo.id}", given=_errors(servo), allowed="0"
        )
    _stop(servo, index, config)
    lower, upper, _ = config.limits
    angle = joint_angle(servo.read(PRESENT_POSITION), config.zeros[index], config.signs[index])
    turns = whole_turns(angle, float(lower[index]), float(upper[index]))
    limits = servo.read(VELOCITY_LIMIT), servo.read(CURRENT_LIMIT)
    return ReadyServo(servo.id, servo.model, servo.firmware, *limits, turns, tuple(findings))


def arm_watchdog(servo: Servo, config: ServoConfig) -> None:
    """Set the bus watchdog, after clearing it: once it has fired, nothing else clears it."""
    servo.write(BUS_WATCHDOG, WATCHDOG_OFF)
    servo.write(BUS_WATCHDOG, config.watchdog_counts)


def rest(servo: Servo, index: int, config: ServoConfig) -> None:
    """Leave a servo at rest; only then its watchdog goes off, so that it does not fire for want of a program."""
    if servo.read(BUS_WATCHDOG) == WATCHDOG_FIRED:
        _clear_watchdog(servo, index, config)
    _stop(servo, index, config)
    servo.write(BUS_WATCHDOG, WATCHDOG_OFF)
    if config.torque_off_at_stop:
        servo.write(TORQUE_ENABLE, TORQUE_OFF)


def _errors(servo: Servo) -> str:
    bits = HardwareError(servo.read(HARDWARE_ERROR))
    return f"hardware error {int(bits)} ({bits.name or 'unknown'}), {servo.read(PRESENT_TEMPERATURE)} °C"


def _clear_errors(servo: Servo, config: ServoConfig, reboot: bool) -> None:
    """A servo that has shut down comes back only by a reboot."""
    if not _shut_down(servo):
        return
    if not reboot:
        raise BackendError("the servo has shut down", field=f"servo {servo.id}", given=_errors(servo),
                           allowed="no hardware error; a reboot clears it")  # fmt: skip
    temperature = servo.read(PRESENT_TEMPERATURE)
    if temperature >= config.hot_temperature:
        raise BackendError("the servo is too hot to be rebooted", field=f"servo {servo.id}", given=f"{temperature} °C",
                           allowed=f"below {config.hot_temperature:g} °C")  # fmt: skip
    servo.reboot(config.boot_timeout)
    servo.identify(config.models)
    servo.write_unanswered(STATUS_RETURN_LEVEL, ANSWER_ALL)
    if _shut_down(servo):
        raise BackendError("a hardware error persists after a reboot", field=f"servo {servo.id}", given=_errors(servo),
                           allowed="no hardware error")  # fmt: skip


def _shut_down(servo: Servo) -> int:
    """Errors that have taken the torque, or should have; a voltage out of range does so only where the servo is told to."""
    return servo.read(HARDWARE_ERROR) & (~VOLTAGE_ONLY | servo.read(SHUTDOWN))


def _goal(index: int, config: ServoConfig) -> Register:
    return GOAL_VELOCITY if index < config.n_joints else GOAL_CURRENT


def _stop(servo: Servo, index: int, config: ServoConfig) -> None:
    servo.write(_goal(index, config), 0)


def _clear_watchdog(servo: Servo, index: int, config: ServoConfig) -> None:
    """Clear the watchdog, so that goals are accepted; the old one is zeroed at once, before any answer could be awaited."""
    servo.clear_watchdog(_goal(index, config))
    servo.write(BUS_WATCHDOG, WATCHDOG_OFF)


def _stand_still(servo: Servo, index: int, config: ServoConfig) -> None:
    """Clear the watchdog, and make zero the goal; profile, gains and power limit as at the factory."""
    _clear_watchdog(servo, index, config)
    _stop(servo, index, config)
    for gain, value in FACTORY_GAINS.items():
        _ensure(servo, gain, value)
    _ensure(servo, PROFILE_ACCELERATION, 0)
    _ensure(servo, GOAL_PWM, servo.read(PWM_LIMIT))


def _ensure(servo: Servo, register: Register, value: int) -> None:
    if servo.read(register) != value:
        servo.write(register, value)


def _gather_telemetry(servo: Servo) -> None:
    """Point the indirect addresses at the telemetry block; left alone where they do already."""
    # Torque goes off for that, as it is after power-up: some servos refuse them with torque on, which another program left.
    if servo.read_bytes(INDIRECT_ADDRESS, len(MAPPING), "indirect addresses") == MAPPING:
        return
    _ensure(servo, TORQUE_ENABLE, TORQUE_OFF)
    servo.write_bytes(INDIRECT_ADDRESS, MAPPING, "indirect addresses")
    if servo.read_bytes(INDIRECT_ADDRESS, len(MAPPING), "indirect addresses") != MAPPING:
        raise BackendError("the servo did not keep the indirect addresses", field=f"servo {servo.id}",
                           allowed="firmware with indirect addresses in RAM")  # fmt: skip
