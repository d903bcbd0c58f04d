"""`doorman fly`: who hears the signals. The flights themselves are in `tests/rig`."""

from __future__ import annotations

import signal
from typing import cast

import pytest

from doorman.cli.fly import _ctrl_c
from doorman.flight import FlightSession

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Session:
    """Notes what it is asked."""

    def __init__(self) -> None:
        self.asked: list[str] = []

    def interrupt(self) -> None:
        self.asked.append("interrupt")

    def terminate(self) -> None:
        self.asked.append("terminate")


@pytest.fixture
def session():
    before = {number: signal.getsignal(number) for number in SIGNALS}
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # the tests themselves may run by nohup
    yield Session()
    for number, handler in before.items():
        signal.signal(number, handler)


def test_signals_go_to_the_session_as_long_as_it_flies(session):
    before = [signal.getsignal(number) for number in SIGNALS]
    with _ctrl_c(cast(FlightSession, session)):
        for number in SIGNALS:
            signal.raise_signal(number)
    assert session.asked == ["interrupt", "terminate", "terminate"]
    assert [signal.getsignal(number) for number in SIGNALS] == before


def test_a_terminal_that_is_gone_does_not_concern_a_flight_by_nohup(session):
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    with _ctrl_c(cast(FlightSession, session)):
        signal.raise_signal(signal.SIGHUP)
    assert session.asked == []
