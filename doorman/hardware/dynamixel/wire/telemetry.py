"""The block of registers that every cycle reads, gathered through indirect data so that one sync read gets all of it."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from doorman.hardware.dynamixel.wire import registers as reg

BLOCK: tuple[reg.Register, ...] = (
    reg.PRESENT_POSITION, reg.PRESENT_VELOCITY, reg.PRESENT_CURRENT, reg.HARDWARE_ERROR, reg.PRESENT_TEMPERATURE,
    reg.PRESENT_VOLTAGE, reg.TORQUE_ENABLE, reg.BUS_WATCHDOG, reg.REALTIME_TICK,
)  # fmt: skip
"""In the order of their bytes."""
BLOCK_SIZE = sum(register.size for register in BLOCK)
assert BLOCK_SIZE <= reg.INDIRECT_COUNT
MAPPING = b"".join(
    (register.address + offset).to_bytes(2, "little") for register in BLOCK for offset in range(register.size)
)
"""Content of the indirect addresses that gathers the block."""
_CODES = {(1, False): "B", (2, False): "H", (2, True): "h", (4, True): "i"}
_LAYOUT = struct.Struct("<" + "".join(_CODES[register.size, register.signed] for register in BLOCK))


@dataclass(frozen=True, slots=True)
class Telemetry:
    """Registers of one servo at one time, as counts."""

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
        return cls(*_LAYOUT.unpack(data))

    def is_ours(self, watchdog_counts: int) -> bool:
        """Whether the block still shows what it was set up to show; a servo that restarted shows zeros."""
        if self.bus_watchdog == reg.WATCHDOG_OFF:
            return self.torque_enable == reg.TORQUE_ON and self.voltage > 0
        return self.bus_watchdog in (watchdog_counts, reg.WATCHDOG_FIRED)
