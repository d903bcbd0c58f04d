"""Opening and closing the way to the servos: port, link, and every servo made ready or left at rest."""

from __future__ import annotations

from dataclasses import dataclass

from doorman.clocks import REAL_TIME, Clock
from doorman.exceptions import BackendError
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.faults import ServoEvent
from doorman.hardware.dynamixel.setup.commissioning import ReadyServo, arm_watchdog, commission, rest
from doorman.hardware.dynamixel.setup.settings import TOLERATED_RETURN_DELAY
from doorman.hardware.dynamixel.setup.talk import Servo
from doorman.hardware.dynamixel.wire.link import Link
from doorman.hardware.dynamixel.wire.port import PortLost, SerialPort
from doorman.hardware.dynamixel.wire.registers import RETURN_DELAY_UNIT
from doorman.hardware.events import EventLog

LONGEST_LATENCY_TIMER = 1.5e-3
"""A USB adapter that keeps bytes back for longer spoils the cycle [s]."""
REST_TIMEOUT = 0.5
"""Time for leaving all servos at rest [s]."""


@dataclass(frozen=True)
class Connection:
    """An open port, with a patient link for set-up and a quick one for cycles."""

    config: ServoConfig
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
        patient = Link(port, config.baud_rate, config.setup_latency, clock=clock.now)
        delay = TOLERATED_RETURN_DELAY * RETURN_DELAY_UNIT
        return cls(config, port, patient, Link(port, config.baud_rate, config.latency, delay, clock.now), clock)

    def servos(self, link: Link | None = None, timeout: float | None = None) -> list[Servo]:
        """Servos to talk with, by default at leisure."""
        deadline = self.clock.now() + (self.config.open_timeout if timeout is None else timeout)
        return [Servo(link or self.patient, self.config, index, deadline) for index in range(self.config.n)]

    def commission(self, log: EventLog[ServoEvent]) -> tuple[ReadyServo, ...]:
        """Make every servo ready, torque on, standing still under its watchdog."""
        servos, config = self.servos(), self.config
        for servo in servos:  # all there and of a known model, before anything is written anywhere
            servo.identify()
        try:
            ready = tuple(
                commission(servo, log, reboot=config.reboot_at_open, write_eeprom=config.write_eeprom)
                for servo in servos
            )
            for servo in servos:
                arm_watchdog(servo)
        except BaseException:
            self.rest()
            raise
        return ready

    def rest(self) -> list[str]:
        failures = []
        for servo in self.servos(self.quick, REST_TIMEOUT):
            try:
                rest(servo)
            except PortLost as error:
                return [str(error)]
            except BackendError as error:
                failures.append(str(error))
        return failures
