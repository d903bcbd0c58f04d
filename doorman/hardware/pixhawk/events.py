"""What can happen on the link to the autopilot, as typed events, and which of it lasts."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from threading import Lock
from types import MappingProxyType


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
    """Condition: the controller stopped sending setpoints; the vehicle is told to hold."""
    MOCAP_LOST = "mocap lost"
    """Condition: no fresh pose to send."""
    BATTERY_LOW = "battery low"
    """Condition: voltage or charge below the threshold, or the autopilot says so."""
    BATTERY_SILENT = "battery silent"
    """Condition: the autopilot is heard, and does not tell the charge any more that it told."""
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


CONDITIONS = frozenset(
    {
        EventKind.LINK_LOST,
        EventKind.DEVICE_LOST,
        EventKind.HEARTBEAT_LOST,
        EventKind.STATE_STALE,
        EventKind.CLOCK_UNSYNCHRONISED,
        EventKind.SETPOINT_STALE,
        EventKind.MOCAP_LOST,
        EventKind.BATTERY_LOW,
        EventKind.BATTERY_SILENT,
        EventKind.AUTOPILOT_FAILSAFE,
        EventKind.CONTROL_LOST,
    }
)
"""Kinds that begin and end."""


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


class EventLog:
    """Newest events and the conditions that hold; written by one thread, read by any."""

    def __init__(self, capacity: int = 1000) -> None:
        self._lock = Lock()
        self._events: deque[Event] = deque(maxlen=capacity)
        self._conditions: frozenset[EventKind] = frozenset()
        self._last_noted: dict[EventKind, float] = {}

    @property
    def conditions(self) -> frozenset[EventKind]:
        """Conditions that hold now."""
        return self._conditions

    def happen(self, kind: EventKind, time: float, message: str, **values: object) -> None:
        """Note an event."""
        with self._lock:
            self._events.append(Event(kind, time, message, values=MappingProxyType(values)))

    def happen_at_most(self, period: float, kind: EventKind, time: float, message: str, **values: object) -> None:
        if time - self._last_noted.get(kind, float("-inf")) >= period:
            self._last_noted[kind] = time
            self.happen(kind, time, message, **values)

    def condition(self, kind: EventKind, holds: bool, time: float, message: str, **values: object) -> bool:
        """Begin or end a condition."""
        with self._lock:
            if holds == (kind in self._conditions):
                return False
            self._conditions = self._conditions | {kind} if holds else self._conditions - {kind}
            text = message if holds else f"no longer: {message}"
            self._events.append(Event(kind, time, text, holds, MappingProxyType(values)))
        return True

    def drain(self) -> tuple[Event, ...]:
        with self._lock:
            events = tuple(self._events)
            self._events.clear()
        return events
