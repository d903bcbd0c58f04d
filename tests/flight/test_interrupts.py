"""Signals in a program that flies a backend by itself: what reaches it as an exception, and how often."""

from __future__ import annotations

import signal
import time

import pytest

from doorman.flight import flying_backend
from doorman.flight.flying_backend import _ended_by_exceptions


def test_two_interrupts_at_once_are_one(monkeypatch):
    """A process group and its parent both send one; the second must not end what the first began."""
    before = signal.getsignal(signal.SIGINT)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with _ended_by_exceptions(lambda: True):
            monkeypatch.setattr(flying_backend, "SAME_INTERRUPT", 60.0)  # however slow the machine
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
            signal.raise_signal(signal.SIGINT)
            monkeypatch.setattr(flying_backend, "SAME_INTERRUPT", 0.01)
            time.sleep(0.02)
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)


def test_handlers_of_the_program_stay():
    heard = []
    before = signal.signal(signal.SIGINT, lambda number, frame: heard.append(number))
    try:
        with _ended_by_exceptions(lambda: True):
            signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)
    assert heard == [signal.SIGINT]
