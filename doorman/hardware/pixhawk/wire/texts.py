"""STATUSTEXTs that come in parts of 50 characters, put together again.

ArduPilot ends a text of 50, 100 … characters with an empty part, PX4 does not; and a part may be lost. So what has come is told
when the text is whole, when another one begins, or when the rest is late.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from doorman.hardware.pixhawk.link.exchange import StatusText
from doorman.hardware.pixhawk.wire.messages import Message

_PART = 50
"""Characters of a part that is not the last."""
_PARTS = 8
"""Most parts of a text; further ones are not read."""
_LATE = 0.3
"""After its last part so far, a text is told as it is [s]."""
_COPIES = 1.0
"""For so long after that, a part with the same numbers is a copy [s]."""


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
        """Texts that are complete now."""
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
