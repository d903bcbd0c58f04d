"""pymavlink's messages, which only this place imports, and units of their fields: "unknown" on the wire becomes NaN here."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from typing import Any

from doorman.exceptions import BackendError, how_to_install

try:
    from pymavlink.dialects.v20 import ardupilotmega
except ImportError as _error:
    raise BackendError("MAVLink needs pymavlink", allowed=how_to_install("hardware")) from _error

Message = Any
"""A message, whose fields are attributes."""

mavlink: Any = ardupilotmega
"""Message classes and constants of MAVLink 2: the common ones and ArduPilot's."""
IDENTIFIERS: dict[str, int] = {kind.msgname: number for number, kind in mavlink.mavlink_map.items()}
"""Identifier of a message by its name."""


class BodyThrustMessage(ardupilotmega.MAVLink_set_attitude_target_message):  # type: ignore[misc]
    """SET_ATTITUDE_TARGET with its extension `thrust_body`, which ArduPilot's dialect does not have."""

    def __init__(self, thrust_body: Sequence[float], *fields: Any) -> None:
        super().__init__(*fields)
        self.thrust_body = tuple(thrust_body)

    def pack(self, mav: Any, force_mavlink1: bool = False) -> bytes:
        """Bytes of the message; an extension follows its fields, and is no part of its checksum's seed."""
        rates = self.body_roll_rate, self.body_pitch_rate, self.body_yaw_rate
        target = self.target_system, self.target_component, self.type_mask
        payload = self.unpacker.pack(self.time_boot_ms, *self.q, *rates, self.thrust, *target)
        extended = payload + struct.pack("<3f", *self.thrust_body)
        data: bytes = self._pack(mav, self.crc_extra, extended, force_mavlink1=force_mavlink1)
        return data


def command_message(target: tuple[int, int], number: int, *parameters: float, confirmation: int = 0) -> Message:
    """COMMAND_LONG."""
    padded = [*parameters, *[0.0] * (7 - len(parameters))]
    return mavlink.MAVLink_command_long_message(*target, number, confirmation, *padded)


_UNKNOWN = 0xFFFF
_WRAP_MS = 1 << 32


def seconds_to_boot_ms(seconds: float) -> int:
    """Time [s] as the 32 bit count of milliseconds that MAVLink stamps carry."""
    return round(seconds * 1e3) % _WRAP_MS


def boot_ms_difference(newer: int, older: int) -> int:
    """Signed difference of two 32 bit stamps [ms], across a wrap too."""
    return (newer - older + _WRAP_MS // 2) % _WRAP_MS - _WRAP_MS // 2


def figure(raw: int, unit: float) -> float:
    """Figure of a battery, of a field in such units; NaN where the autopilot does not know it."""
    return raw * unit if 0 <= raw < _UNKNOWN else math.nan


def cells_to_volts(cells: list[int]) -> float:
    """Sum of the cells' voltages of BATTERY_STATUS [V]; NaN where no cell is known."""
    # A pack of more than 65.5 V is sent as several full "cells", which this adds up too.
    known = [cell for cell in cells if cell != _UNKNOWN]
    return sum(known) * 1e-3 if known else math.nan
