"""What every solver of the comparison looks like to the worker that runs it."""

from __future__ import annotations

from abc import ABC, abstractmethod

from suite.task import Answer, Array, Task


class Unsupported(Exception):
    """The solver cannot do this; the message says why."""


class Peer(ABC):
    """A solver set up for one task.

    Only `solve` is timed. What comes before and after it, assembling guesses and taking results apart, is not: in a peer's
    favour, since for doorman all of that happens inside its one call.
    """

    def __init__(self, task: Task) -> None:
        self.task = task

    @abstractmethod
    def prepare_cold(self, state: Array) -> None:
        """Make ready for a solve from hover inputs to convergence."""

    def prepare_replan(self, state: Array) -> None:
        """Make ready for one iteration from the shifted previous answer."""
        raise Unsupported("no single iteration from a shifted plan")

    @abstractmethod
    def solve(self) -> None:
        """The call that is timed."""

    def own_seconds(self) -> float | None:
        """Duration of the last `solve` by the solver's own clock [s]; None: what the call took counts."""
        return None

    @abstractmethod
    def answer(self) -> Answer:
        """What the last `solve` found."""
