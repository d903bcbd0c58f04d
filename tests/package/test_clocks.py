"""The computer's clock; the virtual one is held by whatever waits on it in the tests of links and emulators."""

from __future__ import annotations

import socket

from doorman.clocks import REAL_TIME


def test_it_is_never_early_and_hears_who_is_spoken_to():
    moment = REAL_TIME.now() + 0.01
    REAL_TIME.reach(moment)
    assert REAL_TIME.now() >= moment
    with socket.socket(type=socket.SOCK_DGRAM) as receiver, socket.socket(type=socket.SOCK_DGRAM) as other:
        for each in (receiver, other):
            each.bind(("127.0.0.1", 0))
        assert REAL_TIME.readable([receiver, other], 0.01) == []
        other.sendto(b"x", receiver.getsockname())
        assert REAL_TIME.readable([receiver, other], 60.0) == [receiver]
