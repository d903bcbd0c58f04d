"""Lines of bytes on real sockets and a pseudo-terminal."""

from __future__ import annotations

import contextlib
import os
import select
import socket
import termios
import tty

import pytest
from pixhawk_rig import free_port, wait_until

from doorman.clocks import REAL_TIME
from doorman.exceptions import BackendError
from doorman.hardware.pixhawk.wire.connection import parse_connection
from doorman.hardware.pixhawk.wire.transport import DeviceLost, open_line


@pytest.fixture
def opened():
    lines = []

    def open_one(text: str, timeout: float = 1.0):
        lines.append(open_line(parse_connection(text), timeout))
        return lines[-1]

    yield open_one
    for line in lines:
        line.close()
        line.close()


def read(line, size: int) -> bytes:
    data = b""

    def look() -> bool:
        nonlocal data
        data += b"".join(piece for piece, _ in line.receive())
        return len(data) >= size

    assert wait_until(look, clock=REAL_TIME)
    return data


def test_udp_listens_on_loopback_and_answers_its_peer(opened):
    port = free_port()
    line = opened(f"udp:{port}")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        other.settimeout(5.0)
        assert not line.send(b"to nobody")
        other.sendto(b"hello", ("127.0.0.1", port))
        select.select([line], [], [], 5.0)
        ((data, sender),) = line.receive()
        assert (data, sender) == (b"hello", other.getsockname())
        line.peer = sender
        assert line.send(b"answer")
        assert other.recv(100) == b"answer"


def test_udp_calls_a_listener_and_survives_that_nobody_is_there(opened):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        other.settimeout(5.0)
        line = opened(f"udpout:127.0.0.1:{other.getsockname()[1]}")
        assert line.send(b"hello")
        assert other.recv(100) == b"hello"
    for _ in range(3):
        line.send(b"gone")
        assert line.receive() == []


def test_udp_calls_from_the_same_port_again(opened):
    """PX4 answers whoever called it first."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(5.0)
        own = free_port()
        first = opened(f"udpout:localhost:{listener.getsockname()[1]}:{own}")
        first.send(b"first")
        assert listener.recvfrom(100) == (b"first", ("127.0.0.1", own))
        any_port = opened(f"udpout:localhost:{listener.getsockname()[1]}")
        any_port.send(b"any")
        _, sender = listener.recvfrom(100)
        any_port.close()
        again = open_line(any_port.endpoint, 1.0)
        again.send(b"again")
        assert listener.recvfrom(100) == (b"again", sender)
        again.close()


def test_tcp_sends_receives_and_notices_the_end(opened):
    with socket.create_server(("127.0.0.1", 0)) as server:
        line = opened(f"tcp:127.0.0.1:{server.getsockname()[1]}")
        other, _ = server.accept()
        with other:
            assert line.send(b"hello")
            assert other.recv(100) == b"hello"
            other.sendall(b"answer")
            assert read(line, 6) == b"answer"
            assert line.receive() == []
    select.select([line], [], [], 5.0)
    with pytest.raises(DeviceLost):
        line.receive()


def test_what_cannot_be_opened_is_an_error_in_time(opened):
    taken, free = free_port(), free_port()
    opened(f"udp:{taken}")
    for connection in (f"udp:{taken}", f"tcp:127.0.0.1:{free}", "/dev/no-such-port"):
        with pytest.raises(BackendError, match="cannot be opened"):
            opened(connection)


def test_a_serial_line_carries_all_bytes_both_ways_and_notices_that_it_is_unplugged(opened):
    master, slave = os.openpty()
    tty.setraw(master)
    every = bytes(range(256))
    try:
        line = opened(f"serial:{os.ttyname(slave)}:57600")
        os.close(slave)
        assert line.receive() == []
        os.write(master, every)
        assert read(line, 256) == every
        assert line.send(every)
        select.select([master], [], [], 5.0)
        assert os.read(master, 1000) == every
    finally:
        os.close(master)
    with pytest.raises(DeviceLost):
        for _ in range(3):
            line.receive()
            line.send(b"x")


def test_a_stream_is_busy_while_the_device_takes_no_more(opened):
    with socket.create_server(("127.0.0.1", 0)) as server:
        line = opened(f"tcp:127.0.0.1:{server.getsockname()[1]}")
        other, _ = server.accept()
        with other:
            assert not line.busy
            while not line.busy:
                line.send(bytes(1000))
            with pytest.raises(DeviceLost, match="does not read"):
                for _ in range(100_000):
                    line.send(bytes(1000))
            other.setblocking(False)

            def drained() -> bool:
                with contextlib.suppress(BlockingIOError):
                    other.recv(1 << 20)
                line.receive()
                return not line.busy

            assert wait_until(drained, clock=REAL_TIME)


def test_a_device_that_goes_again_while_it_is_opened(monkeypatch):
    """Pyserial lets through what the terminal says."""
    master, slave = os.openpty()

    def gone(*_: object) -> None:
        raise termios.error(5, "Input/output error")

    monkeypatch.setattr(termios, "tcsetattr", gone)
    try:
        with pytest.raises(BackendError, match="cannot be opened"):
            open_line(parse_connection(f"serial:{os.ttyname(slave)}:57600"), 0.2)
    finally:
        os.close(master)
        os.close(slave)
