"""Answers of the autopilot, handed from the thread of the link to callers that wait for them.

STATUSTEXTs that come in parts of 50 characters, put together again.

ArduPilot ends a text of 50, 100 … characters with an empty part, PX4 does not; and a part may be lost. So what has come is
reported when the text is whole, when another one begins, or when the rest is late.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import NamedTuple, TypeVar

from doorman.clocks import LONGEST_WAIT, REAL_TIME, Clock
from doorman.hardware.pixhawk.config import HEARTBEAT, PROMPT
from doorman.hardware.pixhawk.wire.messages import Message

T = TypeVar("T")


class Answer(NamedTuple):
    number: int  # counts all that were received
    value: float  # of a parameter, or the result of a command
    kind: int  # MAV_PARAM_TYPE of a parameter


class StatusText(NamedTuple):
    time: float
    severity: int  # MAV_SEVERITY; lower is worse
    text: str


class Exchange:
    """Newest answers; every post wakes the waiting callers."""

    def __init__(self, time: Clock = REAL_TIME) -> None:
        self._time = time
        self._condition = time.condition()
        self.count = 0  # number of the newest answer: later ones are newer than a question that is asked now
        self._answers: dict[int | str, Answer] = {}  # by number of the command, or name of the parameter
        self._texts: deque[StatusText] = deque(maxlen=100)

    def post(self, question: int | str, value: float, kind: int = 0) -> None:
        """Note the answer to a command, or the value of a parameter."""
        with self._condition:
            self.count += 1
            self._answers[question] = Answer(self.count, value, kind)
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
            self._answers.clear()
            self._texts.clear()

    def answer(self, question: int | str, after: int) -> Answer | None:
        """Answer that came after a question was asked; None if none came."""
        found = self._answers.get(question)
        return found if found is not None and found.number > after else None

    def texts(self, since: float, severity: int = 7) -> list[str]:
        """Texts since a time, without repetitions."""
        with self._condition:
            told = [one.text for one in self._texts if one.time >= since and one.severity <= severity]
        return list(dict.fromkeys(told))

    def wait(self, find: Callable[[], T | None], timeout: float) -> T | None:
        deadline = self._time.now() + timeout
        while True:
            with self._condition:
                found = find()
                remaining = deadline - self._time.now()
                if found is not None or remaining <= 0.0:
                    return found
                self._condition.wait(min(remaining, LONGEST_WAIT))


_PART = 50
"""Characters of a part that is not the last."""
_PARTS = 8
"""Most parts of a text; further ones are not read."""


class TextParts:
    """Texts of one autopilot; one at a time, as they come."""

    def __init__(self) -> None:
        self._identifier, self._severity = 0, 0
        self._parts: dict[int, str] = {}
        self._untold: set[int] = set()  # numbers of the parts that were not reported yet
        self._since = -math.inf  # when the last part so far came [s]

    def take(self, message: Message, now: float) -> list[StatusText]:
        if message.id == 0:
            return [_status_text(now, message.severity, message.text)]
        texts: list[StatusText] = []
        if message.id != self._identifier or now - self._since > HEARTBEAT:
            texts = self._told(now)
            self._identifier, self._severity, self._parts = message.id, message.severity, {}
        if message.chunk_seq < _PARTS and message.chunk_seq not in self._parts:
            self._parts[message.chunk_seq], self._since = message.text, now
            self._untold.add(message.chunk_seq)
        last = max(self._parts, default=-1)
        whole = len(self._parts) == last + 1 and len(self._parts.get(last, "")) < _PART
        return texts + self._told(now) if whole else texts

    def late(self, now: float) -> list[StatusText]:
        """Texts whose rest does not come."""
        return self._told(now) if now - self._since > PROMPT else []

    def _told(self, now: float) -> list[StatusText]:
        numbers, self._untold = sorted(self._untold), set()
        return [_status_text(now, self._severity, "".join(map(self._parts.__getitem__, numbers)))] if numbers else []


def _status_text(now: float, severity: int, text: str) -> StatusText:
    """What can be printed of it; PX4 ends with a tab what it tells as an event, too."""
    printable = (character if character.isprintable() else "?" for character in text.rstrip("\t"))
    return StatusText(now, severity, "".join(printable))
