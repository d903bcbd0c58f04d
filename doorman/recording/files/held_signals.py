"""Signals that wait until a message is whole."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def signals_held_back() -> Iterator[None]:
    """Let SIGINT, SIGTERM, SIGHUP and SIGQUIT wait until the block is done; Python runs handlers in the main thread only."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    with _held_back(signal.SIGINT), _held_back(signal.SIGTERM), _held_back(signal.SIGHUP), _held_back(signal.SIGQUIT):
        yield


@contextmanager
def _held_back(number: signal.Signals) -> Iterator[None]:
    handler = signal.getsignal(number)
    if not callable(handler):  # left to the operating system
        yield
        return
    caught: list[FrameType | None] = []
    signal.signal(number, lambda _, frame: caught.append(frame))
    try:
        yield
    finally:
        signal.signal(number, handler)
        for frame in caught:  # where one raises, the rest are lost in what it raises
            handler(number, frame)
