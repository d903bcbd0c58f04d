"""What can happen on the link to the autopilot, as typed events, which of it lasts, and how a request to it ends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from threading import Lock
from types import MappingProxyType

from doorman.background import EventLog
from doorman.hardware.pixhawk.config import HEARTBEAT

RARELY = 60 * HEARTBEAT
"""Another station is told of, and remembered, once in so long [s]."""


class EventKind(Enum):
    """Kinds of events; those that last are conditions, which begin and end."""

    LINK_LOST = "link lost"
    """Condition: no valid message from the autopilot."""
    DEVICE_LOST = "device lost"
    """Condition: the port or connection itself is gone."""
    HEARTBEAT_LOST = "heartbeat lost"
    """Condition: messages come, heartbeats do not."""
    STATE_STALE = "state stale"
    """Condition: attitude or position is older than allowed."""
    CLOCK_UNSYNCHRONISED = "clock unsynchronised"
    """Condition: stamps of the autopilot cannot be mapped to this computer's clock."""
    SETPOINT_STALE = "setpoint stale"
    """Condition: the controller stopped sending setpoints; the link makes the vehicle hold."""
    MOCAP_LOST = "mocap lost"
    """Condition: no fresh pose to send."""
    BATTERY_LOW = "battery low"
    """Condition: voltage or charge below the threshold, or the autopilot says so."""
    BATTERY_SILENT = "battery silent"
    """Condition: the autopilot is heard, and no longer reports the charge that it has reported."""
    AUTOPILOT_FAILSAFE = "autopilot failsafe"
    """Condition: the autopilot reports itself critical or worse."""
    CONTROL_LOST = "control lost"
    """Condition: the mode was changed by someone else, by radio or failsafe; nothing is commanded until `engage`."""

    CONNECTED = "connected"
    MODE_CHANGED = "mode changed"
    ARMED = "armed"
    DISARMED = "disarmed"
    REBOOTED = "rebooted"
    CLOCK_JUMPED = "clock jumped"
    STATUS_TEXT = "status text"
    COMMAND_REFUSED = "command refused"
    COMMAND_UNANSWERED = "command unanswered"
    CORRUPTED = "corrupted messages"
    DISORDERED = "duplicated or reordered messages"
    INVALID_DATA = "invalid data"
    FOREIGN = "foreign messages"
    PEER_CHANGED = "another peer"
    BAD_SIGNATURE = "bad signature"
    IO_FAILED = "input or output failed"


@dataclass(frozen=True)
class Event:
    """Something that happened."""

    kind: EventKind
    time: float
    """On this computer's monotonic clock [s]."""
    message: str
    begins: bool = True
    """False where a condition ends."""
    values: Mapping[str, object] = field(default_factory=lambda: MappingProxyType({}))
    """Figures to it."""


class LinkLog(EventLog[Event]):
    """The events of a link, and the conditions that hold; written by one thread, read by any."""

    def __init__(self, size: int = 1000) -> None:
        super().__init__(size)
        self._lock = Lock()
        self.conditions: frozenset[EventKind] = frozenset()
        self._last_noted: dict[EventKind, float] = {}

    def happen(self, kind: EventKind, time: float, message: str, **values: object) -> None:
        self.write(Event(kind, time, message, values=MappingProxyType(values)))

    def happen_at_most(self, period: float, kind: EventKind, time: float, message: str, **values: object) -> None:
        """Note an event unless one of its kind was noted a short time ago: floods stay readable."""
        if time - self._last_noted.get(kind, float("-inf")) >= period:
            self._last_noted[kind] = time
            self.happen(kind, time, message, **values)

    def condition(self, kind: EventKind, holds: bool, time: float, message: str, **values: object) -> bool:
        """Begin or end a condition; whether it changed."""
        with self._lock:
            if holds == (kind in self.conditions):
                return False
            self.conditions = self.conditions ^ {kind}
            text = message if holds else f"no longer: {message}"
            self.write(Event(kind, time, text, holds, MappingProxyType(values)))
        return True


class OutcomeStatus(Enum):
    """Ends of a request."""

    DONE = "done"
    REFUSED = "refused"
    """The autopilot said no."""
    TIMED_OUT = "timed out"
    NOT_READY = "not ready"
    """Something that it needs is missing: the message says what."""
    CONTROL_LOST = "control lost"
    """Someone else changed the mode, or the link broke."""


@dataclass(frozen=True)
class Outcome:
    """Result of a request."""

    status: OutcomeStatus
    message: str = ""

    @property
    def done(self) -> bool:
        """Whether it ended as asked."""
        return self.status is OutcomeStatus.DONE

    def __str__(self) -> str:
        return f"{self.status.value}: {self.message}" if self.message else self.status.value
