"""What every solver of the standard problems looks like to the worker that runs it; only `solve` is timed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace

from suite.peers.interface import Unsupported
from suite.standard.task import Case, StandardTask
from suite.task import Answer, shifted


class StandardPeer(ABC):
    """A solver set up for one task."""

    def __init__(self, task: StandardTask) -> None:
        self.task = task

    @abstractmethod
    def prepare_cold(self, case: Case) -> None:
        """Make ready for a solve from the case's guess to convergence."""

    def prepare_replan(self, case: Case) -> None:
        """Make ready for one iteration from the shifted previous answer; the case's guess does not count."""
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

    def follow(self, case: Case) -> Case:
        """The case with the shifted previous answer for a guess."""
        answer = self.answer()
        states, inputs = shifted(answer.states, answer.inputs)
        return replace(case, states=states, inputs=inputs)
