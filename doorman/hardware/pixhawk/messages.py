"""pymavlink's messages: the one place that imports them."""

from __future__ import annotations

from typing import Any

from doorman.exceptions import BackendError

try:
    from pymavlink.dialects.v20 import ardupilotmega
except ImportError as _error:
    raise BackendError("MAVLink needs pymavlink", allowed="pip install 'doorman[hardware]'") from _error

Message = Any
"""A message, whose fields are attributes."""

mavlink: Any = ardupilotmega
"""Message classes and constants of MAVLink 2: the common ones and ArduPilot's."""
