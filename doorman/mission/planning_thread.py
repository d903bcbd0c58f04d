"""A thread that plans while the controller goes on."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import TracebackType
from typing import Generic, TypeVar

from doorman.hardware.scheduling import give_way

Order = TypeVar("Order")
Answer = TypeVar("Answer")

_LAST_WAIT = 2.0
"""Longest wait for a plan that is still being made when the mission ends [s]."""


class PlanningThread(Generic[Order, Answer]):
    """Carries out one order at a time; whoever gives orders never waits."""

    def __init__(self, carry_out: Callable[[Order], Answer]) -> None:
        self._carry_out = carry_out
        self._changed = threading.Condition()
        self._order: Order | None = None
        self._answer: Answer | None = None
        self._error: Exception | None = None
        self._asked_at = 0.0
        self._stopping = False
        # a daemon: an executor's thread would keep a process from ending for as long as one plan hangs
        self._thread = threading.Thread(target=self._run, name="planner", daemon=True)

    def __enter__(self) -> PlanningThread[Order, Answer]:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        with self._changed:
            self._stopping = True
            self._changed.notify()
        if self._thread.ident is not None:
            self._thread.join(_LAST_WAIT)

    @property
    def busy(self) -> bool:
        """Whether an order is being carried out, or its answer has not been taken."""
        return self._order is not None or self._answer is not None or self._error is not None

    def at_work(self, now: float) -> float:
        """Time for which the present order has been carried out; 0 if there is none [s]."""
        return 0.0 if self._order is None else now - self._asked_at

    def begin(self, order: Order, now: float) -> None:
        """Have an order carried out; only while not busy."""
        with self._changed:
            assert not self.busy, "one order at a time"
            self._order, self._asked_at = order, now
            self._changed.notify()
        if self._thread.ident is None:  # begun here, it is scheduled as the controller is
            self._thread.start()

    def take(self) -> Answer | None:
        """What came of the last order, once; None while it is being carried out."""
        with self._changed:
            answer, error = self._answer, self._error
            self._answer = self._error = None
        if error is not None:
            raise error
        return answer

    def _run(self) -> None:
        give_way()
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._stopping or self._order is not None)
                order = self._order
                if self._stopping or order is None:
                    return
            answer: Answer | None = None
            error: Exception | None = None
            try:
                answer = self._carry_out(order)
            except Exception as raised:  # whoever waits for the answer must hear of it
                error = raised
            with self._changed:
                self._answer, self._error, self._order = answer, error, None
