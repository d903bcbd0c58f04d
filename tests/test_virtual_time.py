"""Virtual time, on which the tests of links and emulators stand: it passes while everybody waits, and only then."""

from __future__ import annotations

import os
import socket
import threading
import time
from collections.abc import Iterator

import pytest
from virtual_time import CLOCK, Aside

from doorman.clocks import REAL_TIME


def test_hours_pass_at_once_and_in_order():
    begin, seen = CLOCK.now(), []
    others = [
        Aside(lambda hours=hours: seen.append((hours, CLOCK.now() - begin)), 3600.0 * hours) for hours in (3, 1, 2)
    ]
    CLOCK.sleep(2.5 * 3600.0)
    assert [hours for hours, _ in seen] == [1, 2]
    for other in others:
        other.result()
    assert [at for _, at in seen] == pytest.approx([3600.0, 7200.0, 10800.0])


def test_time_stands_still_while_somebody_computes():
    begin = CLOCK.now()
    waiting = Aside(lambda: CLOCK.now() - begin, 1.0)
    time.sleep(0.05)  # as if a busy machine had held this thread up
    assert CLOCK.now() == begin
    assert waiting.result() == pytest.approx(1.0)


@pytest.fixture
def sockets() -> Iterator[tuple[socket.socket, socket.socket]]:
    """Two that may be sent to."""
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other,
    ):
        for each in (one, other):
            each.bind(("127.0.0.1", 0))
        yield one, other


def test_what_is_written_arrives_before_time_passes(sockets):
    (receiver, unheard), (master, slave), begin = sockets, os.openpty(), CLOCK.now()

    def write() -> None:
        os.write(slave, b"x\n")
        unheard.sendto(b"x", receiver.getsockname())

    writer = Aside(write, 1.0)
    assert CLOCK.readable([unheard], 0.5) == [] and CLOCK.now() == pytest.approx(begin + 0.5)
    assert CLOCK.readable([receiver], 60.0) == [receiver] and CLOCK.now() == pytest.approx(begin + 1.0)
    assert CLOCK.readable([master], 60.0) == [master] and CLOCK.now() == pytest.approx(begin + 1.0)
    writer.result()
    os.close(master)
    os.close(slave)


def test_events_and_conditions_end_waits_and_have_time_outs():
    event, condition, told = CLOCK.event(), CLOCK.condition(), []
    begin = CLOCK.now()
    assert not event.wait(2.0) and CLOCK.now() == pytest.approx(begin + 2.0)

    def tell() -> None:
        event.set()
        CLOCK.sleep(1.0)
        with condition:
            told.append(True)
            condition.notify_all()

    Aside(tell, 1.0)
    assert event.wait(60.0) and CLOCK.now() == pytest.approx(begin + 3.0)
    with condition:
        assert condition.wait_for(lambda: told, 60.0) and CLOCK.now() == pytest.approx(begin + 4.0)
        assert not condition.wait_for(lambda: False, 1.0) and CLOCK.now() == pytest.approx(begin + 5.0)


def test_who_holds_a_lock_may_wait():
    lock, begin = CLOCK.lock(), CLOCK.now()
    with lock, lock:
        other = Aside(
            lambda: (lock.acquire(timeout=1.0), lock.acquire(timeout=60.0), CLOCK.now() - begin, lock.release())
        )
        CLOCK.sleep(3.0)
    refused, taken, at, _ = other.result()
    assert not refused and taken and at == pytest.approx(3.0)


def test_a_join_has_a_time_out_and_an_error_is_raised_where_it_is_asked_for():
    never, over = CLOCK.event(), CLOCK.event()
    thread = CLOCK.thread(lambda: over.wait(10.0) or never.set())
    thread.start()
    thread.join(1.0)
    assert thread.is_alive()
    thread.join()
    assert never.is_set() and not thread.is_alive()
    with pytest.raises(ZeroDivisionError):
        Aside(lambda: 1 / 0).result()


def test_waiting_for_ever_and_for_nobody_is_an_error():
    with pytest.raises(RuntimeError, match="for ever"):
        CLOCK.event().wait()
    failed: list[RuntimeError] = []

    def wait() -> None:
        try:
            CLOCK.sleep(1.0)
        except RuntimeError as error:
            failed.append(error)

    stranger = threading.Thread(target=wait)
    stranger.start()
    stranger.join()
    assert "no part" in str(failed[0])


def test_the_computer_s_clock_is_never_early(sockets):
    receiver, unheard = sockets
    moment = REAL_TIME.now() + 0.01
    REAL_TIME.reach(moment)
    assert REAL_TIME.now() >= moment
    assert REAL_TIME.readable([receiver, unheard], 0.01) == []
    unheard.sendto(b"x", receiver.getsockname())
    assert REAL_TIME.readable([receiver, unheard], 60.0) == [receiver]
