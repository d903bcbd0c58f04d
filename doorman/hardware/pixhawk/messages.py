"""pymavlink's messages: the one place that imports them."""

from __future__ import annotations

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


def command_message(target: tuple[int, int], number: int, *parameters: float, confirmation: int = 0) -> Message:
    """COMMAND_LONG.

    Args:
        target: System and component.
        number: MAV_CMD.
        parameters: The first of its seven parameters; the rest are 0.
        confirmation: How often it was sent before.
    """
    padded = [*parameters, *[0.0] * (7 - len(parameters))]
    return mavlink.MAVLink_command_long_message(*target, number, confirmation, *padded)
