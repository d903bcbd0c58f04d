"""Recovery of servos that have shut down or restarted, while the bus goes on."""

from __future__ import annotations

from collections.abc import Callable

from doorman.exceptions import BackendError
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.cycle import ServoCycle
from doorman.hardware.dynamixel.faults import LATCHED, ServoEvent, ServoFault
from doorman.hardware.dynamixel.setup.commissioning import arm_watchdog, commission
from doorman.hardware.dynamixel.setup.talk import Servo
from doorman.hardware.dynamixel.wire.link import Link
from doorman.hardware.dynamixel.wire.port import PortLost
from doorman.hardware.events import EventLog


def recover(
    cycle: ServoCycle,
    link: Link,
    config: ServoConfig,
    log: EventLog[ServoEvent],
    deadline: float,
    breathe: Callable[[], None],
) -> list[str]:
    """Set up again every servo that is missing or has a latched fault, with a reboot if it has shut down."""
    # The arm stands still meanwhile.
    failures = []
    for joint, servo_id in enumerate(config.ids):
        if not cycle.monitors[joint].fault & (LATCHED | ServoFault.MISSING):
            continue
        cycle.reader.excluded = joint
        servo = Servo(link, servo_id, deadline, breathe)
        try:
            ready = commission(servo, joint, config, log, reboot=True, write_eeprom=False)
            arm_watchdog(servo, config)
            cycle.replace(joint, ready)
            log.write(ServoEvent(link.now(), servo_id, ServoFault.NONE, True, "set up again"))
        except PortLost:
            raise
        except BackendError as error:
            failures.append(str(error))
            log.write(ServoEvent(link.now(), servo_id, ServoFault.NONE, True, f"not recovered: {error}"))
        finally:
            cycle.reader.excluded = None
    if not failures:
        cycle.bus_fault &= ~ServoFault.INTERNAL
    return failures
