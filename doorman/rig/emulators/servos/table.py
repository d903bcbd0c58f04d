"""Control table of an emulated XH430-W350, as data from its e-manual, and the memory with its rules of access.

Source: ROBOTIS e-Manual, XH430-W350-T/R, "Control Table of EEPROM Area" and "Control Table of RAM Area".
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

EEPROM_END = 64
"""First address of the RAM: values below survive power-off and are locked while torque is on."""
TABLE_END = 662
TICKS_PER_TURN = 4096
"""Counts of a position in one turn."""
UNITS = {"goal velocity": 0.229 * math.tau / 60, "bus watchdog": 0.02, "return delay time": 2e-6}
"""One count of a row, in SI."""
CURRENT_MODE, VELOCITY_MODE = 0, 1
OPERATING_MODES = frozenset((CURRENT_MODE, VELOCITY_MODE, 3, 4, 5, 16))
"""What `operating mode` may hold."""


@dataclass(frozen=True)
class Item:
    name: str
    address: int
    size: int
    initial: int  # value of a new servo (EEPROM) or after power-on (RAM)
    low: int | None = None  # smallest value that may be written; None where the row is read-only
    high: int | None = None
    limited_by: str | None = None  # row that bounds the absolute value

    @property
    def writable(self) -> bool:
        return self.low is not None

    @property
    def signed(self) -> bool:
        return (self.low is not None and self.low < 0) or self.name.startswith("present ")


_EEPROM = [
    Item("model number", 0, 2, 1000),
    Item("model information", 2, 4, 0),
    Item("firmware version", 6, 1, 45),
    Item("id", 7, 1, 1, 0, 252),
    Item("baud rate", 8, 1, 1, 0, 7),
    Item("return delay time", 9, 1, 250, 0, 254),
    Item("drive mode", 10, 1, 0, 0, 13),
    Item("operating mode", 11, 1, 3, 0, 16),
    Item("secondary id", 12, 1, 255, 0, 255),
    Item("protocol type", 13, 1, 2, 1, 2),
    Item("homing offset", 20, 4, 0, -1_044_479, 1_044_479),
    Item("moving threshold", 24, 4, 10, 0, 1023),
    Item("temperature limit", 31, 1, 80, 0, 100),
    Item("max voltage limit", 32, 2, 160, 95, 160),
    Item("min voltage limit", 34, 2, 95, 95, 160),
    Item("pwm limit", 36, 2, 885, 0, 885),
    Item("current limit", 38, 2, 648, 0, 648),
    Item("velocity limit", 44, 4, 130, 0, 1023),
    Item("max position limit", 48, 4, 4095, 0, 4095),
    Item("min position limit", 52, 4, 0, 0, 4095),
    Item("startup configuration", 60, 1, 0, 0, 3),
    Item("shutdown", 63, 1, 52, 0, 63),
]

_RAM = [
    Item("torque enable", 64, 1, 0, 0, 1),
    Item("led", 65, 1, 0, 0, 1),
    Item("status return level", 68, 1, 2, 0, 2),
    Item("registered instruction", 69, 1, 0),
    Item("hardware error status", 70, 1, 0),
    Item("velocity i gain", 76, 2, 1920, 0, 16383),
    Item("velocity p gain", 78, 2, 100, 0, 16383),
    Item("position d gain", 80, 2, 0, 0, 16383),
    Item("position i gain", 82, 2, 0, 0, 16383),
    Item("position p gain", 84, 2, 900, 0, 16383),
    Item("feedforward 2nd gain", 88, 2, 0, 0, 16383),
    Item("feedforward 1st gain", 90, 2, 0, 0, 16383),
    Item("bus watchdog", 98, 1, 0, 0, 127),
    Item("goal pwm", 100, 2, 885, -885, 885, "pwm limit"),
    Item("goal current", 102, 2, 648, -648, 648, "current limit"),
    Item("goal velocity", 104, 4, 0, -1023, 1023, "velocity limit"),
    Item("profile acceleration", 108, 4, 0, 0, 32767),
    Item("profile velocity", 112, 4, 0, 0, 32767),
    Item("goal position", 116, 4, 0, -1_048_575, 1_048_575),
    Item("realtime tick", 120, 2, 0),
    Item("moving", 122, 1, 0),
    Item("moving status", 123, 1, 0),
    Item("present pwm", 124, 2, 0),
    Item("present current", 126, 2, 0),
    Item("present velocity", 128, 4, 0),
    Item("present position", 132, 4, 0),
    Item("velocity trajectory", 136, 4, 0),
    Item("position trajectory", 140, 4, 0),
    Item("present input voltage", 144, 2, 120),
    Item("present temperature", 146, 1, 30),
    Item("backup ready", 147, 1, 0),
]

INDIRECT_BLOCKS = ((168, 224, 28), (578, 634, 28))
"""First indirect address, first indirect data and number of each of the two blocks."""
INDIRECT_LOW, INDIRECT_HIGH = 64, 661
"""Addresses that an indirect address may hold: the RAM area."""

_INDIRECT = [
    item
    for addresses, data, count in INDIRECT_BLOCKS
    for index in range(count)
    for item in (
        Item(f"indirect address {addresses + 2 * index}", addresses + 2 * index, 2, data + index,
             INDIRECT_LOW, INDIRECT_HIGH),
        Item(f"indirect data {data + index}", data + index, 1, 0, 0, 255),
    )
]  # fmt: skip

ITEMS: dict[str, Item] = {item.name: item for item in (*_EEPROM, *_RAM, *_INDIRECT)}
"""Rows by name."""
ITEM_AT: dict[int, Item] = {item.address + offset: item for item in ITEMS.values() for offset in range(item.size)}
"""Row that a byte belongs to."""
GOALS = frozenset(("goal pwm", "goal current", "goal velocity", "goal position"))
"""Rows that a bus watchdog error makes read-only."""
BAUD_RATES = (9600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000)
"""Rate by the content of `baud rate` [bit/s]."""


WATCHDOG_ERROR = 0xFF
"""−1 in the one byte of `bus watchdog`."""


class PacketError(IntEnum):
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
        return int.from_bytes(self._bytes[item.address : item.address + item.size], "little", signed=item.signed)

    def measure(self, name: str) -> float:
        """Value of a row, in SI."""
        return self.get(name) * UNITS[name]

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
            places = range(item.address, item.address + item.size)
            if item.writable and any(place not in written for place in places):
                return PacketError.DATA_LENGTH, []
            value = int.from_bytes(bytes(written.get(place, 0) for place in places), "little", signed=item.signed)
            if (error := self._forbidden(item, value)) is not PacketError.NONE:
                return error, []
            changes.append((item, value))
        return PacketError.NONE, changes

    def _forbidden(self, item: Item, value: int) -> PacketError:
        if item.low is None or item.high is None:
            return PacketError.ACCESS
        locked = item.address < EEPROM_END or item.name.startswith("indirect address")  # the latter with some servos
        if locked and self.get("torque enable"):
            return PacketError.ACCESS
        stopped = item.name in GOALS or (item.name == "bus watchdog" and value != 0)
        if stopped and self.get("bus watchdog") == WATCHDOG_ERROR:
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
