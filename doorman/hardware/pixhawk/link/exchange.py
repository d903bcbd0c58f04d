"""Answers of the autopilot, handed from the thread of the link to callers that wait for them."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from doorman.clocks import REAL_TIME, Clock

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
        self._count = 0
        self._acknowledgements: deque[Acknowledgement] = deque(maxlen=64)
        self._parameters: dict[str, ParameterValue] = {}
        self._texts: deque[StatusText] = deque(maxlen=100)

    @property
    def count(self) -> int:
        """Number of the newest answer: later ones are newer than a question that is asked now."""
        return self._count

    def post_acknowledgement(self, command: int, result: int) -> None:
        with self._condition:
            self._count += 1
            self._acknowledgements.append(Acknowledgement(self._count, command, result))
            self._condition.notify_all()

    def post_parameter(self, name: str, value: float, kind: int) -> None:
        with self._condition:
            self._count += 1
            self._parameters[name] = ParameterValue(self._count, value, kind)
            self._condition.notify_all()

    def post_text(self, text: StatusText) -> None:
        with self._condition:
            self._texts.append(text)

    def wake(self) -> None:
        """Let waiting callers look again."""
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
        """Wait until something is found."""
        deadline = self._time.now() + timeout
        while True:
            with self._condition:
                found = find()
                remaining = deadline - self._time.now()
                if found is not None or remaining <= 0.0:
                    return found
                self._condition.wait(min(remaining, 0.1))
