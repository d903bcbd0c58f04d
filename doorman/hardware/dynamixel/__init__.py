"""Servos: an arm of DYNAMIXEL XH430 on a serial bus, commanded by joint rates."""

from doorman.hardware.dynamixel.bus import ServoBus
from doorman.hardware.dynamixel.commissioning import ReadyServo
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.faults import (
    LATCHED,
    STOPPING,
    WARNINGS,
    BusState,
    BusStatistics,
    ServoEvent,
    ServoFault,
    ServoSample,
)
from doorman.hardware.dynamixel.none import NoServos
from doorman.hardware.dynamixel.registers import zero_position
from doorman.hardware.dynamixel.settings import SettingFinding

__all__ = [
    "LATCHED",
    "STOPPING",
    "WARNINGS",
    "BusState",
    "BusStatistics",
    "NoServos",
    "ReadyServo",
    "ServoBus",
    "ServoConfig",
    "ServoEvent",
    "ServoFault",
    "ServoSample",
    "SettingFinding",
    "zero_position",
]
