"""Time, and everything that waits by it: the computer's own here, one that tests step in `tests/helpers/virtual_time.py`."""

from __future__ import annotations

import functools
import select
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeVar


class HasFileno(Protocol):
    """A socket, a line, a device."""

    def fileno(self) -> int:
        """Its descriptor."""


_File = TypeVar("_File", bound="int | HasFileno")


class Clock:
    """The computer's monotonic clock; its threads, events, conditions and locks wait by it. Hold no other lock while waiting."""

    now = staticmethod(time.monotonic)
    """The time [s]."""
    nanoseconds = staticmethod(time.monotonic_ns)
    """The time [ns]."""
    raw = staticmethod(functools.partial(time.clock_gettime, time.CLOCK_MONOTONIC_RAW))
    """The time by an oscillator that no time server slews [s]."""
    sleep = staticmethod(time.sleep)
    """Wait [s]."""
    event = threading.Event
    """Makes an event."""
    condition = threading.Condition
    """Makes a condition."""
    lock = staticmethod(threading.RLock)
    """Makes a lock that a thread may hold while it waits; its owner may take it again."""

    def reach(self, moment: float) -> None:
        """Wait until a moment, exactly."""
        spin = 0.0003  # [s]; the last stretch is waited for by looking at the clock: sleeping is not that exact
        while (left := moment - time.monotonic()) > 0.0:
            if left > spin:
                time.sleep(left - spin)

    def readable(self, files: Sequence[_File], timeout: float) -> list[_File]:
        """Wait until something can be read."""
        return select.select(files, [], [], timeout)[0]

    def thread(self, target: Callable[..., None], *args: Any, name: str | None = None) -> threading.Thread:
        """Make a thread that waits by this clock alone; it ends with the process."""
        return threading.Thread(target=target, args=args, name=name, daemon=True)


REAL_TIME = Clock()
"""The computer's clock, the default of every constructor that waits."""

BRIEFLY = 0.001
"""Between two looks of a thread that must not miss what comes, and that nothing wakes [s]."""
LOOK = 0.02
"""Between two looks at what other threads know: the pace of steps on the ground and of way points in the air [s]."""
LONGEST_WAIT = 5 * LOOK
"""Longest sleep of a device's thread: then it looks whether it is to end, or tries again to open what is gone [s]."""
HELD_UP = 0.5
"""A busy computer holds up a thread for so long at most: who is silent for longer is dead [s]."""
RESTART = 2 * HELD_UP
"""Between two starts of a process that ends by itself, and longest wait for a stopped one to be gone [s]."""
