"""Answers of the autopilot, handed from the thread of the link to callers that wait for them.

STATUSTEXTs that come in parts of 50 characters, put together again.

ArduPilot ends a text of 50, 100 … characters with an empty part, PX4 does not; and a part may be lost. So what has come is
reported when the text is whole, when another one begins, or when the rest is late.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

from doorman.clocks import REAL_TIME, Clock
from doorman.hardware.pixhawk.wire.messages import Message

T = TypeVar("T")


@dataclass(frozen=True)
class Acknowledgement:
    number: int  # counts all that were received
    command: int
    result: int


@dataclass(frozen=True)
class ParameterValue:
    number: int  # counts all that were received
    value: float
    kind: int  # MAV_PARAM_TYPE


@dataclass(frozen=True)
class StatusText:
    time: float
    severity: int  # MAV_SEVERITY; lower is worse
    text: str


class Exchange:
    """Newest answers; every post wakes the waiting callers."""

    def __init__(self, time: Clock = REAL_TIME) -> None:
        self._time = time
        self._condition = time.condition()
        self.count = 0  # number of the newest answer: later ones are newer than a question that is asked now
        self._acknowledgements: deque[Acknowledgement] = deque(maxlen=64)
        self._parameters: dict[str, ParameterValue] = {}
        self._texts: deque[StatusText] = deque(maxlen=100)

    def post_acknowledgement(self, command: int, result: int) -> None:
        with self._condition:
            self.count += 1
            self._acknowledgements.append(Acknowledgement(self.count, command, result))
            self._condition.notify_all()

    def post_parameter(self, name: str, value: float, kind: int) -> None:
        with self._condition:
            self.count += 1
            self._parameters[name] = ParameterValue(self.count, value, kind)
            self._condition.notify_all()

    def post_text(self, text: StatusText) -> None:
        with self._condition:
            self._texts.append(text)

    def wake(self) -> None:
        with self._condition:
            self._condition.notify_all()

    def forget(self) -> None:
        """Drop all answers, as after a reboot."""
        with self._condition:
            self._acknowledgements.clear()
            self._parameters.clear()
            self._texts.clear()

    def acknowledgement(self, command: int, after: int) -> Acknowledgement | None:
        """Newest acknowledgement of a command after a question; None if there is none."""
        with self._condition:
            matching = [one for one in self._acknowledgements if one.command == command and one.number > after]
        return matching[-1] if matching else None

    def parameter(self, name: str, after: int) -> ParameterValue | None:
        """Value of a parameter that came after a question; None if none came."""
        found = self._parameters.get(name)
        return found if found is not None and found.number > after else None

    def texts(self, since: float, severity: int = 7) -> list[str]:
        """Texts since a time, without repetitions."""
        with self._condition:
            return list(
                dict.fromkeys(one.text for one in self._texts if one.time >= since and one.severity <= severity)
            )

    def wait(self, find: Callable[[], T | None], timeout: float) -> T | None:
        deadline = self._time.now() + timeout
        while True:
            with self._condition:
                found = find()
                remaining = deadline - self._time.now()
                if found is not None or remaining <= 0.0:
                    return found
                self._condition.wait(min(remaining, 0.1))


_PART = 50
"""Characters of a part that is not the last."""
_PARTS = 8
"""Most parts of a text; further ones are not read."""
_LATE = 0.3
"""Silence after its last part, after which a text is reported as it is [s]."""
_COPIES = 1.0
"""Time after that in which a part with the same numbers counts as a copy [s]."""


@dataclass
class _Begun:
    identifier: int
    since: float  # when the last part so far came [s]
    severity: int
    parts: dict[int, str] = field(default_factory=dict)

    @property
    def whole(self) -> bool:
        """Whether a part that is the last one has come, and all before it."""
        last = max(self.parts)
        return len(self.parts) == last + 1 and len(self.parts[last]) < _PART


class TextParts:
    """Texts of one autopilot; one at a time, as they come."""

    def __init__(self) -> None:
        self._begun: _Begun | None = None
        self._ended: tuple[int, frozenset[int], float] = (0, frozenset(), -math.inf)

    def take(self, message: Message, now: float) -> list[StatusText]:
        if message.id == 0:
            return [_status_text(now, message.severity, message.text)]
        identifier, numbers, ended = self._ended
        if message.id == identifier and message.chunk_seq in numbers and now - ended < _COPIES:
            return []
        begun, texts = self._begun, []
        if begun is None or begun.identifier != message.id:
            texts = self._end(now)
            begun = self._begun = _Begun(message.id, now, message.severity)
        if message.chunk_seq < _PARTS:
            begun.parts[message.chunk_seq], begun.since = message.text, now
        return texts + (self._end(now) if begun.parts and begun.whole else [])

    def late(self, now: float) -> list[StatusText]:
        """Texts whose rest does not come."""
        return self._end(now) if self._begun is not None and now - self._begun.since > _LATE else []

    def _end(self, now: float) -> list[StatusText]:
        begun, self._begun = self._begun, None
        if begun is None or not begun.parts:
            return []
        self._ended = begun.identifier, frozenset(begun.parts), now
        return [_status_text(now, begun.severity, "".join(begun.parts[number] for number in sorted(begun.parts)))]


def _status_text(now: float, severity: int, text: str) -> StatusText:
    """What can be printed of it; PX4 ends with a tab what it tells as an event, too."""
    printable = (character if character.isprintable() else "?" for character in text.rstrip("\t"))
    return StatusText(now, severity, "".join(printable))
