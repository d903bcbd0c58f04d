"""One emulated servo: instructions, torque, bus watchdog, protection and reboot."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from types import MappingProxyType

from doorman.rig.emulators.servos.packets import BROADCAST, Instruction
from doorman.rig.emulators.servos.table import (
    BAUD_RATES,
    CURRENT_MODE,
    TICKS_PER_TURN,
    UNITS,
    VELOCITY_MODE,
    WATCHDOG_ERROR,
    PacketError,
    ServoMemory,
)

CURRENT_UNITS = MappingProxyType({1000: 2.69e-3, 1010: 2.69e-3, 1040: 1.34e-3, 1050: 1.34e-3})
"""One count of a current by model number [A]."""
ALERT = 0x80
VOLTAGE, OVERHEATING, ENCODER, SHOCK, OVERLOAD = 0x01, 0x04, 0x08, 0x10, 0x20
"""Bits of hardware error status and of shutdown."""
READY = MappingProxyType({"baud rate": 3, "return delay time": 0, "operating mode": VELOCITY_MODE})
"""EEPROM of a servo that is set up for 1 Mbaud and velocity mode."""
READY_TO_GRIP = MappingProxyType({**READY, "operating mode": CURRENT_MODE})
"""EEPROM of a servo that is set up for 1 Mbaud and current mode, as a gripper needs it."""


@dataclass
class ServoSetup:
    servo_id: int
    eeprom: dict[str, int] = field(default_factory=lambda: dict(READY))
    """Rows that differ from a new servo's, by name."""
    zero: int = 2048  # encoder's tick at the joint's zero
    direction: int = 1  # +1 where the servo's positive direction is the joint's, else −1
    boot_time: float = 0.1  # silence after a reboot [s]
    reboot_delay: float = 0.0  # how long it goes on answering after the instruction to reboot [s]
    astray: float = 0.3  # rate of a servo that does not see itself turn, whatever its goal [rad/s]
    damping: float = 0.2  # friction in current mode, as current per rate [A s/rad]
    spring: float = 0.0  # current that balances a spring, which turns the joint down [A]


class EmulatedServo:
    def __init__(self, setup: ServoSetup) -> None:
        self.setup = setup
        self.memory = ServoMemory(setup.eeprom | {"id": setup.servo_id})
        self.lasting_errors = 0  # hardware error bits whose cause persists; a reboot does not help against them
        self._turn_base: int | None = None
        self._heard = 0.0
        self._booted = 0.0
        self._silent_until = -math.inf
        self._reboots_at = math.inf

    @property
    def servo_id(self) -> int:
        return self.memory.get("id")

    @property
    def baud_rate(self) -> int:
        """Rate at which it listens and speaks [bit/s]."""
        return BAUD_RATES[self.memory.get("baud rate")]

    def is_up(self, time: float) -> bool:
        return time >= self._silent_until

    def sense(self, time: float, angle: float, rate: float, current: float) -> None:
        """Take over the plant's motion into the registers, and let watchdog and protection act."""
        if self._reboot_if_due(time):
            return
        memory, sign, reverse = self.memory, self.setup.direction, self._reverse
        ticks = self.setup.zero + round(sign * angle * TICKS_PER_TURN / (2.0 * math.pi))
        if self._turn_base is None:
            self._turn_base = reverse * (reverse * ticks // TICKS_PER_TURN * TICKS_PER_TURN)
        counts = round(sign * rate / UNITS["goal velocity"])
        if memory.get("hardware error status") & ENCODER:
            counts = 0  # it does not see itself turn: the position stands, too
        else:
            memory.set("present position", reverse * (ticks - self._turn_base) + memory.get("homing offset"))
        memory.set("present velocity", reverse * counts)
        if memory.get("operating mode") == CURRENT_MODE:
            memory.set("present current", memory.get("goal current") if self._is_on(time) else 0)
        else:
            memory.set("present current", reverse * round(sign * current / self._current_unit))
        memory.set("moving", int(abs(counts) > memory.get("moving threshold")))
        memory.set("realtime tick", int((time - self._booted) * 1000.0) % 32768)
        self._watch_bus(time)
        self._protect()

    def is_driven(self, time: float) -> bool:
        """Whether torque or a spring moves the joint."""
        return self._has_torque(time) or self.setup.spring != 0.0

    def goal_rate(self, time: float) -> float:
        """Rate that motor and spring bring about, in the joint's sign; in modes of position and PWM nothing moves."""
        # In current mode, what the spring leaves of the current works against friction; without torque, the spring alone does.
        memory = self.memory
        on, mode = self._is_on(time), memory.get("operating mode")
        sign = self.setup.direction * self._reverse
        if mode == CURRENT_MODE:
            current = sign * memory.get("goal current") * self._current_unit if on else 0.0
            return (current - self.setup.spring) / self.setup.damping
        if on and memory.get("hardware error status") & ENCODER:
            return self.setup.astray
        if mode == VELOCITY_MODE and on:
            return sign * memory.measure("goal velocity")
        return 0.0

    def hear(self, time: float) -> None:
        """Note that an instruction packet went over the bus: that is what the bus watchdog watches."""
        self._heard = time

    def execute(self, time: float, instruction: Instruction) -> tuple[int, bytes] | None:
        error, data = self._carry_out(instruction)
        level = {0x01: 0, 0x02: 1}.get(instruction.code, 2)
        answers = self.memory.get("status return level") >= level
        if instruction.servo_id == BROADCAST:
            answers = instruction.code == 0x01 and instruction.intact
        status = (self.error_byte(error), data) if answers else None
        if instruction.code == 0x08 and instruction.intact:
            self._reboots_at = min(self._reboots_at, time + self.setup.reboot_delay)
            self._reboot_if_due(time)
        return status

    def _carry_out(self, instruction: Instruction) -> tuple[PacketError, bytes]:
        memory, parameters = self.memory, instruction.parameters
        if not instruction.intact:
            return PacketError.CRC, b""
        address, length = int.from_bytes(parameters[:2], "little"), int.from_bytes(parameters[2:], "little")
        match instruction.code:
            case 0x01:  # model number and firmware version
                return PacketError.NONE, memory.read(0, 2)[1] + memory.read(6, 1)[1]
            case 0x02:
                return memory.read(address, length) if len(parameters) == 4 else (PacketError.DATA_LENGTH, b"")
            case 0x03:
                return self.write(address, parameters[2:]), b""
            case 0x08:
                return PacketError.NONE, b""
        return PacketError.INSTRUCTION, b""

    def error_byte(self, error: PacketError) -> int:
        """Error byte of a status packet: error number, with the alert bit while a hardware error stands."""
        return int(error) | (ALERT if self.memory.get("hardware error status") else 0)

    def write(self, address: int, data: bytes) -> PacketError:
        memory = self.memory
        error, changes = memory.check_write(address, data)
        changed = {item.name: value for item, value in changes}
        if changed.get("torque enable"):
            if self._is_shut_down():
                return PacketError.RESULT_FAIL  # only a reboot brings torque back
            if not memory.get("torque enable"):
                changed = {"goal velocity": 0, "goal current": 0} | changed
        if "operating mode" in changed:
            limits = {"goal pwm": memory.get("pwm limit"), "goal current": memory.get("current limit")}
            changed |= {"profile velocity": 0, "profile acceleration": 0, **limits}
        for name, value in changed.items():
            memory.set(name, value)
        return error

    def reboot(self, time: float) -> None:
        """Restart: RAM goes back to its initial values and the position into one turn."""
        temperature, voltage = self.memory.get("present temperature"), self.memory.get("present input voltage")
        self.memory.power_on()
        self.memory.set("present temperature", temperature)
        self.memory.set("present input voltage", voltage)
        self._turn_base = None
        self._reboots_at = math.inf
        self._booted = self._heard = time
        self._silent_until = time + self.setup.boot_time

    def trip(self, bits: int) -> None:
        """Raise hardware errors, as an overload does; those in `shutdown` take the torque."""
        self.memory.set("hardware error status", self.memory.get("hardware error status") | bits)
        if self._is_shut_down():
            self.memory.set("torque enable", 0)

    @property
    def _reverse(self) -> int:
        return -1 if self.memory.get("drive mode") & 1 else 1

    @property
    def _current_unit(self) -> float:
        return CURRENT_UNITS.get(self.memory.get("model number"), CURRENT_UNITS[1000])

    def _has_torque(self, time: float) -> bool:
        return self.is_up(time) and bool(self.memory.get("torque enable"))

    def _is_on(self, time: float) -> bool:
        return self._has_torque(time) and self.memory.get("bus watchdog") != WATCHDOG_ERROR

    def _is_shut_down(self) -> bool:
        return bool(self.memory.get("hardware error status") & self.memory.get("shutdown"))

    def _reboot_if_due(self, time: float) -> bool:
        due = time >= self._reboots_at
        if due:
            self.reboot(time)
        return due

    def _watch_bus(self, time: float) -> None:
        allowed = self.memory.get("bus watchdog")
        watches = self.memory.get("torque enable") and 1 <= allowed <= 127
        if watches and time - self._heard > self.memory.measure("bus watchdog"):
            # It stops; that its goal becomes zero, the manual does not say.
            self.memory.set("bus watchdog", WATCHDOG_ERROR)

    def _protect(self) -> None:
        memory = self.memory
        bits = self.lasting_errors
        if memory.get("present temperature") > memory.get("temperature limit"):
            bits |= OVERHEATING
        low, high = memory.get("min voltage limit"), memory.get("max voltage limit")
        if not low <= memory.get("present input voltage") <= high:
            bits |= VOLTAGE
        if bits or self._is_shut_down():
            self.trip(bits)
