"""From a servo in any state to one that follows velocities under a bus watchdog, and back to rest."""

from __future__ import annotations

from dataclasses import dataclass

from doorman.background import EventLog, Opened
from doorman.clocks import HELD_UP, REAL_TIME, Clock
from doorman.exceptions import BackendError
from doorman.hardware.dynamixel import registers as reg
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.faults import ServoEvent
from doorman.hardware.dynamixel.link import Link
from doorman.hardware.dynamixel.port import PortLost, SerialPort
from doorman.hardware.dynamixel.registers import Unit, joint_angle, whole_turns
from doorman.hardware.dynamixel.settings import (
    TOLERATED_RETURN_DELAY,
    Servo,
    SettingFinding,
    check_settings,
    write_settings,
)


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
    """Whole turns to add to its angle, so that it lies between the joint's limits [rad]."""
    findings: tuple[SettingFinding, ...]
    """Settings that differ and were not changed."""

    @property
    def current_unit(self) -> float:
        """One count of a current [A]."""
        return Unit.CURRENT[self.model]


def commission(servo: Servo, log: EventLog[ServoEvent], *, write_eeprom: bool) -> ReadyServo:
    """Make a servo ready: identified, settings checked, telemetry block gathered, standing still with torque on."""
    # The bus watchdog is left off, since the next instruction may take a while: `arm_watchdog` sets it.
    servo.make_answer()
    findings = check_settings(servo)
    _clear_errors(servo)
    if write_eeprom and findings:
        write_settings(servo, findings, log)
        findings = check_settings(servo)
    blocking = [finding for finding in findings if finding.blocking]
    if blocking:
        kept = ", ".join(finding.register for finding in blocking if not finding.writable)
        how = "write_eeprom (doorman fly --write-eeprom) changes them" + (f", but never {kept}" if kept else "")
        raise BackendError("; ".join(map(str, blocking)), field="servos", allowed=f"settings as above; {how}")
    _stand_still(servo)
    _gather_telemetry(servo)
    servo.write(reg.TORQUE_ENABLE, reg.TORQUE_ON)
    if servo.read(reg.TORQUE_ENABLE) != reg.TORQUE_ON:
        raise servo.error("the torque cannot be switched on", _errors(servo), "0")
    servo.write(servo.goal, 0)
    config, index = servo.config, servo.index
    angle = joint_angle(servo.read(reg.PRESENT_POSITION), config.zeros[index], config.signs[index])
    turns = whole_turns(angle, float(config.limits.lower[index]), float(config.limits.upper[index]))
    limits = servo.read(reg.VELOCITY_LIMIT), servo.read(reg.CURRENT_LIMIT)
    return ReadyServo(servo.id, servo.model, servo.firmware, *limits, turns, tuple(findings))


def arm_watchdog(servo: Servo) -> None:
    """Set the bus watchdog, after clearing it: once it has fired, nothing else clears it."""
    servo.write(reg.BUS_WATCHDOG, reg.WATCHDOG_OFF)
    servo.write(reg.BUS_WATCHDOG, servo.config.watchdog_counts)


def rest(servo: Servo) -> None:
    """Leave a servo at rest; only then its watchdog goes off, so that it does not fire for want of a program."""
    if servo.read(reg.BUS_WATCHDOG) == reg.WATCHDOG_FIRED:
        servo.clear_watchdog()
    servo.write(servo.goal, 0)
    servo.write(reg.BUS_WATCHDOG, reg.WATCHDOG_OFF)
    if servo.config.torque_off_at_stop:
        servo.write(reg.TORQUE_ENABLE, reg.TORQUE_OFF)


def _errors(servo: Servo) -> str:
    bits = reg.HardwareError(servo.read(reg.HARDWARE_ERROR))
    return f"hardware error {int(bits)} ({bits.name or 'unknown'}), {servo.read(reg.PRESENT_TEMPERATURE)} °C"


def _clear_errors(servo: Servo) -> None:
    """A servo that has shut down comes back only by a reboot."""
    if not _shut_down(servo):
        return
    temperature, hot = servo.read(reg.PRESENT_TEMPERATURE), servo.config.hot_temperature
    if temperature >= hot:
        raise servo.error("the servo is too hot to be rebooted", f"{temperature} °C", f"below {hot:g} °C")
    servo.reboot()
    servo.make_answer()
    if _shut_down(servo):
        raise servo.error("a hardware error persists after a reboot", _errors(servo), "no hardware error")


def _shut_down(servo: Servo) -> int:
    """Errors that have taken the torque, or should have; a voltage out of range does so only where `shutdown` says so."""
    return servo.read(reg.HARDWARE_ERROR) & (~int(reg.HardwareError.VOLTAGE) | servo.read(reg.SHUTDOWN))


def _stand_still(servo: Servo) -> None:
    """Clear the watchdog, and make zero the goal; profile, gains and power limit as at the factory."""
    servo.clear_watchdog()
    servo.write(servo.goal, 0)
    for gain, value in reg.FACTORY_GAINS.items():
        servo.ensure(gain, value)
    servo.ensure(reg.PROFILE_ACCELERATION, 0)
    servo.ensure(reg.GOAL_PWM, servo.read(reg.PWM_LIMIT))


def _gather_telemetry(servo: Servo) -> None:
    """Point the indirect addresses at the telemetry block; left alone where they do already."""
    # Torque goes off for that, as it is after power-up: some servos refuse them with torque on, which another program left.
    if servo.read(reg.MAPPING) == reg.MAPPED:
        return
    servo.ensure(reg.TORQUE_ENABLE, reg.TORQUE_OFF)
    servo.write(reg.MAPPING, reg.MAPPED)
    if servo.read(reg.MAPPING) != reg.MAPPED:
        raise servo.error(
            "the servo did not keep the indirect addresses", None, "firmware with indirect addresses in RAM"
        )


LATENCY_TIMER = 1
"""A USB adapter that keeps bytes back for longer spoils the cycle [ms]."""


class Connection(Opened):
    """A port, with a patient link for set-up and a quick one for cycles."""

    def __init__(self, config: ServoConfig, clock: Clock = REAL_TIME) -> None:
        self._config, self._clock = config, clock
        self._port = port = SerialPort(config.port, config.baud_rate, clock)
        self._patient = Link(port, config.baud_rate, config.setup_latency, clock=clock.now)
        delay = TOLERATED_RETURN_DELAY * Unit.RETURN_DELAY
        self.quick = Link(port, config.baud_rate, config.latency, delay, clock.now)

    def open(self) -> None:
        self._port.open()
        timer = self._port.latency_timer
        if timer is not None and timer > LATENCY_TIMER:
            self.stop()
            raise BackendError("the USB adapter's latency timer is too slow", field="servos.port", given=f"{timer} ms",
                               allowed="1 ms: write 1 to latency_timer of the device in /sys/bus/usb-serial/devices")  # fmt: skip

    def stop(self) -> None:
        self._port.close()

    def servos(self, link: Link | None = None, timeout: float | None = None) -> list[Servo]:
        """Servos to talk with, by default at leisure."""
        deadline = self._clock.now() + (self._config.open_timeout if timeout is None else timeout)
        return [Servo(link or self._patient, self._config, index, deadline) for index in range(self._config.n)]

    def commission(self, log: EventLog[ServoEvent]) -> tuple[ReadyServo, ...]:
        """Make every servo ready, torque on, standing still under its watchdog."""
        servos = self.servos()
        for servo in servos:  # all there and of a known model, before anything is written anywhere
            servo.identify()
        try:
            ready = tuple(commission(servo, log, write_eeprom=self._config.write_eeprom) for servo in servos)
            for servo in servos:
                arm_watchdog(servo)
        except BaseException:
            self.rest()
            raise
        return ready

    def rest(self) -> list[str]:
        """Leave all servos at rest; what failed."""
        failures = []
        for servo in self.servos(self.quick, HELD_UP):
            try:
                rest(servo)
            except PortLost as error:
                return [str(error)]
            except BackendError as error:
                failures.append(str(error))
        return failures
