"""Opening and closing the way to the servos: port, link, and every servo made ready or left at rest."""

from __future__ import annotations

from dataclasses import dataclass

from doorman.clocks import REAL_TIME, Clock
from doorman.exceptions import BackendError
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.faults import ServoEvent
from doorman.hardware.dynamixel.setup.commissioning import ReadyServo, arm_watchdog, commission, inspect, position, rest
from doorman.hardware.dynamixel.setup.settings import TOLERATED_RETURN_DELAY, SettingFinding
from doorman.hardware.dynamixel.setup.talk import Servo
from doorman.hardware.dynamixel.wire.link import Link
from doorman.hardware.dynamixel.wire.port import PortLost, SerialPort
from doorman.hardware.dynamixel.wire.units import RETURN_DELAY_UNIT
from doorman.hardware.events import EventLog

LONGEST_LATENCY_TIMER = 1.5e-3
"""A USB adapter that keeps bytes back for longer spoils the cycle [s]."""
REST_TIMEOUT = 0.5
"""Time for leaving all servos at rest [s]."""


@dataclass(frozen=True)
class Connection:
    """An open port, with a patient link for set-up and a quick one for cycles."""

    port: SerialPort
    patient: Link
    quick: Link
    clock: Clock = REAL_TIME

    @classmethod
    def open(cls, config: ServoConfig, clock: Clock = REAL_TIME) -> Connection:
        port = SerialPort(config.port, config.baud_rate, clock)
        port.open()
        timer = port.latency_timer
        if timer is not None and timer > LONGEST_LATENCY_TIMER:
            port.close()
            raise BackendError("the USB adapter's latency timer is too slow", field="servos.port", given=f"{timer * 1e3:g} ms",
                               allowed="1 ms: write 1 to latency_timer of the device in /sys/bus/usb-serial/devices")  # fmt: skip
        delay = TOLERATED_RETURN_DELAY * RETURN_DELAY_UNIT
        return cls(
            port,
            Link(port, config.baud_rate, config.setup_latency, clock=clock.now),
            Link(port, config.baud_rate, config.latency, delay, clock.now),
            clock,
        )

    def inspect(self, config: ServoConfig) -> list[SettingFinding]:
        """Compare the settings of every servo with what is relied on; changes none."""
        deadline = self.clock.now() + config.open_timeout
        findings = []
        for joint, servo_id in enumerate(config.ids):
            findings += inspect(Servo(self.patient, servo_id, deadline), joint, config)
        return findings

    def positions(self, config: ServoConfig) -> list[int]:
        deadline = self.clock.now() + config.open_timeout
        servos = [Servo(self.patient, servo_id, deadline) for servo_id in config.ids]
        return [position(servo, config) for servo in servos]

    def commission(self, config: ServoConfig, log: EventLog[ServoEvent]) -> tuple[ReadyServo, ...]:
        """Make every servo ready, torque on, standing still under its watchdog."""
        deadline = self.clock.now() + config.open_timeout
        servos = [Servo(self.patient, servo_id, deadline) for servo_id in config.ids]
        for servo in servos:  # all there and of a known model, before anything is written anywhere
            servo.identify(config.models)
        try:
            ready = tuple(
                commission(servo, joint, config, log, reboot=config.reboot_at_open, write_eeprom=config.write_eeprom)
                for joint, servo in enumerate(servos)
            )
            for servo in servos:
                arm_watchdog(servo, config)
        except BaseException:
            self.rest(config)
            raise
        return ready

    def rest(self, config: ServoConfig) -> list[str]:
        """Leave every servo at rest."""
        deadline = self.clock.now() + REST_TIMEOUT
        failures = []
        for index, servo_id in enumerate(config.ids):
            try:
                rest(Servo(self.quick, servo_id, deadline), index, config)
            except PortLost as error:
                return [str(error)]
            except BackendError as error:
                failures.append(str(error))
        return failures
