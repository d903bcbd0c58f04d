"""Newest state and newest plan in memory that planner and plant share."""

from __future__ import annotations

import time
from collections.abc import Callable
from multiprocessing.shared_memory import SharedMemory
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Layout(NamedTuple):
    """What a process needs to find its way in the memory."""

    name: str
    nx: int
    nu: int
    horizon: int
    time_step: float


class Board:
    """Two slots, each with a counter that is odd while its one writer writes: a reader that meets a write reads again.

    Args:
        layout: Of memory that exists.
    """

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self._memory = SharedMemory(layout.name)
        self._owner = False
        self._map()

    @classmethod
    def create(cls, model: Any) -> Board:
        """New memory for a model's states and plans.

        Args:
            model: doorman.Model.
        """
        planner = model.scenario.planner
        size = 8 * (4 + model.nx + (planner.horizon_steps + 1) * (model.nx + model.nu))
        memory = SharedMemory(create=True, size=size)
        board = cls(Layout(memory.name, model.nx, model.nu, planner.horizon_steps, planner.time_step))
        memory.close()
        board._owner = True
        board._state[:], board._plan[:] = 0.0, 0.0
        return board

    def write_state(self, measured: float, state: Array) -> None:
        """Post a measured state with its time [s]."""
        self._write(self._state, measured, state)

    def read_state(self) -> tuple[float, Array]:
        """Newest state, with the time at which it was measured [s]."""
        slot = self._read(self._state)
        return float(slot[1]), slot[2:]

    def wait_for_state(self, timeout: float) -> bool:
        """Wait for the first state; false if none comes in time [s]."""
        return _wait(lambda: bool(self._state[0] > 0.0), timeout)

    def write_plan(self, start: float, plan: Any) -> None:
        """Post a plan with the time of its first state [s]."""
        self._write(self._plan, start, np.concatenate([plan.states.ravel(), plan.inputs.ravel()]))

    def read_plan(self) -> tuple[float, Any]:
        """Newest plan, with the time of its first state [s]."""
        slot, layout = self._read(self._plan), self.layout
        split = 2 + (layout.horizon + 1) * layout.nx
        plan = SimpleNamespace(
            states=slot[2:split].reshape(-1, layout.nx), inputs=slot[split:].reshape(-1, layout.nu),
            time_step=layout.time_step,
        )  # fmt: skip
        return float(slot[1]), plan

    def close(self) -> None:
        """Let go of the memory; the one who made it removes it."""
        del self._state, self._plan
        self._memory.close()
        if self._owner:
            self._memory.unlink()

    def _map(self) -> None:
        layout = self.layout
        states, plans = 2 + layout.nx, 2 + (layout.horizon + 1) * layout.nx + layout.horizon * layout.nu
        buffer: Any = self._memory.buf
        everything = np.frombuffer(buffer, dtype=np.float64)
        self._state, self._plan = everything[:states], everything[states : states + plans]

    @staticmethod
    def _write(slot: Array, time_of_it: float, values: Array) -> None:
        slot[0] += 1.0
        slot[1], slot[2:] = time_of_it, values
        slot[0] += 1.0

    @staticmethod
    def _read(slot: Array) -> Array:
        while True:
            before = slot[0]
            copy = slot.copy()
            if before % 2.0 == 0.0 and slot[0] == before:
                return copy


def _wait(condition: Callable[[], bool], timeout: float) -> bool:
    deadline = time.monotonic() + timeout
    while time.monotonic() < deadline:
        if condition():
            return True
        time.sleep(1e-3)
    return False
