"""pymavlink's messages: the one place that imports them."""

from __future__ import annotations

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


class BodyThrustMessage(ardupilotmega.MAVLink_set_attitude_target_message):  # type: ignore[misc]
    """SET_ATTITUDE_TARGET with its extension `thrust_body`, which ArduPilot's dialect does not have."""

    def __init__(self, thrust_body: Sequence[float], *fields: Any) -> None:
        super().__init__(*fields)
        self.thrust_body = tuple(thrust_body)

    def pack(self, mav: Any, force_mavlink1: bool = False) -> bytes:
        """Bytes of the message; an extension follows its fields, and is no part of its checksum's seed."""
        fields = (
            self.time_boot_ms,
            *self.q,
            self.body_roll_rate,
            self.body_pitch_rate,
            self.body_yaw_rate,
            self.thrust,
        )
        payload = self.unpacker.pack(*fields, self.target_system, self.target_component, self.type_mask)
        payload += struct.pack("<3f", *self.thrust_body)
        data: bytes = self._pack(mav, self.crc_extra, payload, force_mavlink1=force_mavlink1)
        return data


def command_message(target: tuple[int, int], number: int, *parameters: float, confirmation: int = 0) -> Message:
    """COMMAND_LONG."""
    padded = [*parameters, *[0.0] * (7 - len(parameters))]
    return mavlink.MAVLink_command_long_message(*target, number, confirmation, *padded)
