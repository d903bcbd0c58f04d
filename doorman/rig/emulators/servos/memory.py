"""Memory of an emulated servo: access rules of the control table, and indirect addressing."""

from __future__ import annotations

from collections.abc import Iterable
from enum import IntEnum

from doorman.rig.emulators.servos.table import (
    EEPROM_END,
    GOALS,
    INDIRECT_BLOCKS,
    ITEM_AT,
    ITEMS,
    OPERATING_MODES,
    TABLE_END,
    Item,
)

WATCHDOG_ERROR = 0xFF
"""−1 in the one byte of `bus watchdog`."""


class PacketError(IntEnum):
    """Error number in a status packet."""

    NONE = 0
    RESULT_FAIL = 1
    INSTRUCTION = 2
    CRC = 3
    DATA_RANGE = 4
    DATA_LENGTH = 5
    DATA_LIMIT = 6
    ACCESS = 7


class ServoMemory:
    """Bytes of one servo, with the rules by which the bus may touch them."""

    def __init__(self, eeprom: dict[str, int]) -> None:
        self._bytes = bytearray(TABLE_END)
        for item in ITEMS.values():
            self.set(item.name, item.initial)
        for name, value in eeprom.items():
            self.set(name, value)
        self.power_on()

    def get(self, name: str) -> int:
        """Value of a row, negative where the row may be and its sign bit is set."""
        item = ITEMS[name]
        signed = (item.low is not None and item.low < 0) or name.startswith("present ")
        return int.from_bytes(self._bytes[item.address : item.address + item.size], "little", signed=signed)

    def set(self, name: str, value: int) -> None:
        """Put a value into a row, past all rules."""
        item = ITEMS[name]
        value &= (1 << 8 * item.size) - 1
        self._bytes[item.address : item.address + item.size] = value.to_bytes(item.size, "little")

    def power_on(self) -> None:
        """Give every row of the RAM its initial value; the goals' initial values are their limits."""
        for item in ITEMS.values():
            if item.address >= EEPROM_END:
                self.set(item.name, item.initial)
        self.set("goal pwm", self.get("pwm limit"))
        self.set("goal current", self.get("current limit"))
        self.set("torque enable", self.get("startup configuration") & 1)

    def read(self, address: int, length: int) -> tuple[PacketError, bytes]:
        where = [self._target(address + offset) for offset in range(length)]
        if length < 1 or any(place not in ITEM_AT for place in where):
            return PacketError.ACCESS, b""
        return PacketError.NONE, bytes(self._bytes[place] for place in where)

    def check_write(self, address: int, data: bytes) -> tuple[PacketError, list[tuple[Item, int]]]:
        """What a write by the bus would change, and whether it may."""
        changes: list[tuple[Item, int]] = []
        written = {self._target(address + offset): byte for offset, byte in enumerate(data)}
        if not data or any(place not in ITEM_AT for place in written):
            return PacketError.ACCESS, []
        for item in dict.fromkeys(ITEM_AT[place] for place in written):
            if not item.writable:
                return PacketError.ACCESS, []
            places = range(item.address, item.address + item.size)
            if any(place not in written for place in places):
                return PacketError.DATA_LENGTH, []
            signed = item.low is not None and item.low < 0
            value = int.from_bytes(bytes(written[place] for place in places), "little", signed=signed)
            if (error := self._forbidden(item, value)) is not PacketError.NONE:
                return error, []
            changes.append((item, value))
        return PacketError.NONE, changes

    def store(self, changes: Iterable[tuple[Item, int]]) -> None:
        """Store what `check_write` allowed."""
        for item, value in changes:
            self.set(item.name, value)

    def _forbidden(self, item: Item, value: int) -> PacketError:
        watchdog_error = self.get("bus watchdog") == WATCHDOG_ERROR
        if item.low is None or item.high is None:
            return PacketError.ACCESS
        locked = item.address < EEPROM_END or item.name.startswith("indirect address")  # the latter with some servos
        if locked and self.get("torque enable"):
            return PacketError.ACCESS
        if watchdog_error and (item.name in GOALS or (item.name == "bus watchdog" and value != 0)):
            return PacketError.DATA_RANGE
        if not item.low <= value <= item.high or (item.name == "operating mode" and value not in OPERATING_MODES):
            return PacketError.DATA_RANGE
        if item.limited_by is not None and abs(value) > self.get(item.limited_by):
            return PacketError.DATA_LIMIT
        return PacketError.NONE

    def _target(self, address: int) -> int:
        """Byte that an address stands for: indirect data lead to where their indirect address points."""
        for addresses, data, count in INDIRECT_BLOCKS:
            if data <= address < data + count:
                pointer = addresses + 2 * (address - data)
                return int.from_bytes(self._bytes[pointer : pointer + 2], "little")
        return address
