"""How a request to the autopilot ended."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


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
