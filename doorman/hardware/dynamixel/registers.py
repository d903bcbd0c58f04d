r"""Registers of the DYNAMIXEL XH430 that the adapter uses, as data.

Source: ROBOTIS e-Manual, XH430-W350-T/R, control table. Numbers are little endian, negative ones in two's complement.
Registers below 64 are EEPROM: they survive power-off and are locked while torque is on. All others forget at power-off.

Units of a servo's registers in SI, and its encoder in the URDF's joint angle.

.. math::
    \eta = s\,(p - p_0)\,\frac{2\pi}{4096}

p is the present position, p₀ the one at the joint's zero, s = ±1 the direction. Source of the units: ROBOTIS e-Manual, XH430.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from types import MappingProxyType
from typing import NamedTuple

TICKS_PER_TURN = 4096
CENTRE = 2048
"""Tick in the middle of the turn."""
TICK_RANGE = 32_768
"""The servo's clock starts again at zero here."""


class Unit:
    """What one count of a register stands for, in SI."""

    ANGLE = math.tau / TICKS_PER_TURN
    VELOCITY = 0.229 * math.tau / 60  # 0.229 rev/min
    CURRENT = MappingProxyType({1000: 2.69e-3, 1010: 2.69e-3, 1040: 1.34e-3, 1050: 1.34e-3})
    """By model number: the models for 24 V have another sensor."""
    VOLTAGE = 0.1
    CLOCK = 1e-3
    WATCHDOG = 0.02
    RETURN_DELAY = 2e-6


def joint_angle(position: int, zero: int, direction: int) -> float:
    """Joint angle η at a present position, before whole turns are added."""
    return direction * (position - zero) * Unit.ANGLE


def zero_position(position: int, angle: float, direction: int) -> int:
    """Present position at the joint's zero, from one reading at a known angle.

    Args:
        position: Present position at that angle [tick].
        angle: Joint angle, as the URDF counts it [rad].
        direction: +1 where the servo's positive direction is the joint's, else −1.

    Returns:
        [tick].
    """
    return position - direction * round(angle / Unit.ANGLE)


def whole_turns(angle: float, lower: float, upper: float) -> float:
    """Turns to add to an angle so that it lies between the joint's limits, or as near to them as it can."""
    # After power-on a servo knows its angle only within one turn; the joint's limits tell which one.
    turn = 2.0 * math.pi
    nearest = round(((lower + upper) / 2.0 - angle) / turn) if math.isfinite(lower + upper) else 0
    excess = {k: max(lower - angle - k * turn, angle + k * turn - upper, 0.0) for k in (0, nearest)}
    return turn * min(excess, key=lambda k: (excess[k], abs(k)))


@dataclass(frozen=True)
class Register:
    name: str
    address: int
    size: int  # in bytes
    signed: bool = False

    def encode(self, value: int) -> bytes:
        return value.to_bytes(self.size, "little", signed=self.signed)

    def decode(self, data: bytes) -> int:
        return int.from_bytes(data, "little", signed=self.signed)


BAUD_RATE = Register("baud rate", 8, 1)
RETURN_DELAY = Register("return delay time", 9, 1)
DRIVE_MODE = Register("drive mode", 10, 1)
OPERATING_MODE = Register("operating mode", 11, 1)
SECONDARY_ID = Register("secondary id", 12, 1)
HOMING_OFFSET = Register("homing offset", 20, 4, signed=True)
TEMPERATURE_LIMIT = Register("temperature limit", 31, 1)
PWM_LIMIT = Register("pwm limit", 36, 2)
CURRENT_LIMIT = Register("current limit", 38, 2)
VELOCITY_LIMIT = Register("velocity limit", 44, 4)
STARTUP_CONFIGURATION = Register("startup configuration", 60, 1)
SHUTDOWN = Register("shutdown", 63, 1)

TORQUE_ENABLE = Register("torque enable", 64, 1)
STATUS_RETURN_LEVEL = Register("status return level", 68, 1)
HARDWARE_ERROR = Register("hardware error status", 70, 1)
VELOCITY_I_GAIN = Register("velocity i gain", 76, 2)
VELOCITY_P_GAIN = Register("velocity p gain", 78, 2)
BUS_WATCHDOG = Register("bus watchdog", 98, 1)
GOAL_PWM = Register("goal pwm", 100, 2, signed=True)
GOAL_CURRENT = Register("goal current", 102, 2, signed=True)
GOAL_VELOCITY = Register("goal velocity", 104, 4, signed=True)
PROFILE_ACCELERATION = Register("profile acceleration", 108, 4)
REALTIME_TICK = Register("realtime tick", 120, 2)
PRESENT_CURRENT = Register("present current", 126, 2, signed=True)
PRESENT_VELOCITY = Register("present velocity", 128, 4, signed=True)
PRESENT_POSITION = Register("present position", 132, 4, signed=True)
PRESENT_VOLTAGE = Register("present input voltage", 144, 2)
PRESENT_TEMPERATURE = Register("present temperature", 146, 1)

BLOCK = (
    PRESENT_POSITION, PRESENT_VELOCITY, PRESENT_CURRENT, HARDWARE_ERROR, PRESENT_TEMPERATURE,
    PRESENT_VOLTAGE, TORQUE_ENABLE, BUS_WATCHDOG, REALTIME_TICK,
)  # fmt: skip
"""Registers of the telemetry block, in the order of their bytes."""
_SIZE = sum(register.size for register in BLOCK)
MAPPING = Register("indirect addresses", 168, 2 * _SIZE)
"""Two-byte addresses, at most 28, that choose what the indirect data show."""
TELEMETRY = Register("indirect data", 224, _SIZE)
"""The telemetry block, once `MAPPING` holds `MAPPED`: each byte shows the one that its indirect address names."""
MAPPED = MAPPING.decode(
    b"".join((register.address + byte).to_bytes(2, "little") for register in BLOCK for byte in range(register.size))
)

MODELS = MappingProxyType({1000: "XH430-W350", 1010: "XH430-W210", 1040: "XH430-V350", 1050: "XH430-V210"})
"""Name by model number."""
FACTORY_CURRENT_LIMITS = MappingProxyType({1000: 648, 1010: 648, 1040: 689, 1050: 689})
"""Content of `current limit` of a new servo by model number; it is the largest."""
FULL_PWM = 885
"""Content of `pwm limit` of a new servo: the whole supply."""
FACTORY_GAINS = MappingProxyType({VELOCITY_I_GAIN: 1920, VELOCITY_P_GAIN: 100})
"""Gains of the velocity's control after power-on."""
BAUD_CODES = MappingProxyType({9600: 0, 57_600: 1, 115_200: 2, 1_000_000: 3, 2_000_000: 4, 3_000_000: 5, 4_000_000: 6})
"""Content of `baud rate` by bit/s."""
OLDEST_FIRMWARE = 38
"""First with bus watchdog and drive mode."""
STARTUP_FIRMWARE = 45
"""First with startup configuration."""

CURRENT_MODE = 0
"""Operating mode in which the goal is a current; a servo whose watchdog has fired turns freely in it."""
VELOCITY_MODE = 1
"""Operating mode in which the goal is a velocity; position limits are ignored there."""
TORQUE_ON, TORQUE_OFF = 1, 0
REVERSED = 0x01
"""Bit of drive mode: positions, velocities and currents count the other way round."""
ANSWER_ALL = 2
"""Status return level at which every instruction is answered."""
WATCHDOG_OFF = 0
WATCHDOG_FIRED = 0xFF
"""−1 as one byte: the motor stopped, and goals are refused until `WATCHDOG_OFF` is written."""
WATCHDOG_LONGEST = 127


class Instruction(IntEnum):
    """Instruction codes that the adapter sends, and the one that it receives."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REBOOT = 0x08
    STATUS = 0x55
    SYNC_READ = 0x82
    SYNC_WRITE = 0x83


class HardwareError(IntFlag):
    """Bits of `hardware error status`, named as the faults that they are."""

    NONE = 0
    VOLTAGE = 0x01
    OVERHEATING = 0x04
    ENCODER = 0x08
    SHOCK = 0x10
    OVERLOAD = 0x20


SHUTDOWN_NEEDED = HardwareError.OVERLOAD | HardwareError.SHOCK | HardwareError.OVERHEATING
"""Errors that must take the torque: the factory's choice."""
_LAYOUT = struct.Struct("<iihBBHBBH")


class Telemetry(NamedTuple):
    """Registers of one servo at one time, as counts; in the order of `BLOCK`."""

    position: int
    velocity: int
    current: int
    hardware_error: int
    temperature: int
    voltage: int
    torque_enable: int
    bus_watchdog: int
    tick: int

    @classmethod
    def decode(cls, data: bytes) -> Telemetry:
        return cls._make(_LAYOUT.unpack(data))

    def is_ours(self, watchdog_counts: int) -> bool:
        """Whether the block still shows what it was set up to show; a servo that restarted shows zeros."""
        if self.bus_watchdog == WATCHDOG_OFF:
            return self.torque_enable == TORQUE_ON and self.voltage > 0
        return self.bus_watchdog in (watchdog_counts, WATCHDOG_FIRED)
