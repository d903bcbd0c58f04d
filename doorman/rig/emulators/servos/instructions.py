"""Instructions of DYNAMIXEL protocol 2.0 that one emulated servo carries out, but for the sync and bulk family."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from doorman.rig.emulators.servos.memory import PacketError, ServoMemory
from doorman.rig.emulators.servos.packets import Instruction

CLEAR_KEY = b"\x01\x44\x58\x4c\x22"


class Unit(Protocol):
    memory: ServoMemory

    def write(self, address: int, data: bytes) -> PacketError:
        """Write to the control table as the bus does."""

    def forget_turns(self) -> None:
        """Count the position within one turn again."""


class Instructions:
    """Instructions of one servo, with what was registered for later."""

    def __init__(self, unit: Unit) -> None:
        self._unit = unit
        self._registered: tuple[int, bytes] | None = None

    def forget(self) -> None:
        self._registered = None

    def carry_out(self, instruction: Instruction) -> tuple[PacketError, bytes]:
        handlers: dict[int, Callable[[Instruction], tuple[PacketError, bytes]]] = {
            0x01: self._ping, 0x02: self._read, 0x03: self._write, 0x04: self._register_write,
            0x05: self._action, 0x06: self._factory_reset, 0x08: self._accept, 0x10: self._clear,
        }  # fmt: skip
        if not instruction.intact:
            return PacketError.CRC, b""
        if instruction.code not in handlers:
            return PacketError.INSTRUCTION, b""
        return handlers[instruction.code](instruction)

    def _ping(self, _: Instruction) -> tuple[PacketError, bytes]:
        model, firmware = self._unit.memory.get("model number"), self._unit.memory.get("firmware version")
        return PacketError.NONE, model.to_bytes(2, "little") + bytes((firmware,))

    def _read(self, instruction: Instruction) -> tuple[PacketError, bytes]:
        if len(instruction.parameters) != 4:
            return PacketError.DATA_LENGTH, b""
        address, length = (int.from_bytes(instruction.parameters[i : i + 2], "little") for i in (0, 2))
        return self._unit.memory.read(address, length)

    def _write(self, instruction: Instruction) -> tuple[PacketError, bytes]:
        address = int.from_bytes(instruction.parameters[:2], "little")
        return self._unit.write(address, instruction.parameters[2:]), b""

    def _register_write(self, instruction: Instruction) -> tuple[PacketError, bytes]:
        address = int.from_bytes(instruction.parameters[:2], "little")
        error, _ = self._unit.memory.check_write(address, instruction.parameters[2:])
        if error is PacketError.NONE:
            self._registered = (address, instruction.parameters[2:])
            self._unit.memory.set("registered instruction", 1)
        return error, b""

    def _action(self, _: Instruction) -> tuple[PacketError, bytes]:
        if self._registered is None:
            return PacketError.INSTRUCTION, b""
        (address, data), self._registered = self._registered, None
        self._unit.memory.set("registered instruction", 0)
        return self._unit.write(address, data), b""

    def _factory_reset(self, _: Instruction) -> tuple[PacketError, bytes]:
        return PacketError.RESULT_FAIL, b""  # nothing here should ever ask for it

    def _accept(self, _: Instruction) -> tuple[PacketError, bytes]:
        return PacketError.NONE, b""

    def _clear(self, instruction: Instruction) -> tuple[PacketError, bytes]:
        if instruction.parameters != CLEAR_KEY:
            return PacketError.DATA_RANGE, b""
        if self._unit.memory.get("present velocity"):
            return PacketError.RESULT_FAIL, b""
        self._unit.forget_turns()
        return PacketError.NONE, b""
