"""Bytes in and out by UDP, TCP or serial line: nothing here ever blocks, but opening, which has a time-out."""

from __future__ import annotations

import array
import contextlib
import errno
import fcntl
import os
import select
import socket
import termios
from abc import ABC, abstractmethod
from dataclasses import replace
from typing import Any

import serial

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk.wire.connection import Endpoint, Transport

Address = tuple[str, int] | None
"""Who sent it; None where there is only one."""

_CHUNK = 65536
_BATCH = 64
"""Datagrams taken at once, so that a flood cannot keep the thread from its other work."""
_BACKLOG = 8192
"""Unsent bytes after which a stream counts as lost: the other side does not read."""
_BUSY = 256
"""Unsent bytes from which on it is busy: the device has been given what it takes, and that is not sent yet."""
_NOT_SENT = 0x894B
"""Linux' SIOCOUTQNSD: bytes in a socket's queue that have not been sent once."""


class DeviceLost(Exception):
    """The port or connection is gone; it may come back."""


class Line(ABC):
    """A socket or a port; what is known of it."""

    peer: Address = None  # where to send on a line with several senders; set once the autopilot is known

    def __init__(self, device: Any, endpoint: Endpoint) -> None:
        self._device = device
        self.endpoint = endpoint
        """Endpoint to reopen where this line is lost: the same host without a new look-up, from the same port."""
        os.set_blocking(device.fileno(), False)

    @property
    def busy(self) -> bool:
        """Whether what is sent now would wait: better send something newer later."""
        return False

    def fileno(self) -> int:
        """Descriptor to wait on."""
        return int(self._device.fileno())

    @abstractmethod
    def receive(self) -> list[tuple[bytes, Address]]:
        """What has arrived, and from whom."""

    @abstractmethod
    def send(self, data: bytes) -> bool:
        """Send without waiting."""

    def close(self) -> None:
        """Let go of the device; may be called twice."""
        with contextlib.suppress(OSError):
            self._device.close()


class _UdpLine(Line):
    """Datagrams; only `peer` is answered."""

    def receive(self) -> list[tuple[bytes, Address]]:
        datagrams: list[tuple[bytes, Address]] = []
        for _ in range(_BATCH):
            try:
                data, address = self._device.recvfrom(_CHUNK)
            except (BlockingIOError, InterruptedError):
                break
            except ConnectionError:
                continue  # an answer to something we sent: there is no listener yet
            except OSError as error:
                raise DeviceLost(str(error)) from error
            datagrams.append((data, (address[0], address[1])))
        return datagrams

    def send(self, data: bytes) -> bool:
        if self.peer is None:
            return False
        try:
            self._device.sendto(data, self.peer)
        except (BlockingIOError, InterruptedError, ConnectionError):
            return False
        except OSError as error:
            if error.errno in (errno.ENETUNREACH, errno.EHOSTUNREACH, errno.ENOBUFS, errno.ENETDOWN):
                return False
            raise DeviceLost(str(error)) from error
        return True


def _udp_line(endpoint: Endpoint) -> Line:
    device = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        if endpoint.transport is Transport.UDP_LISTEN:
            device.bind((endpoint.host, endpoint.port))
            return _UdpLine(device, endpoint)
        found = socket.getaddrinfo(endpoint.host, endpoint.port, socket.AF_INET, socket.SOCK_DGRAM)
        host, port = str(found[0][4][0]), int(found[0][4][1])
        device.bind(("127.0.0.1" if host.startswith("127.") else "0.0.0.0", endpoint.own_port))
        line = _UdpLine(device, replace(endpoint, host=host, own_port=device.getsockname()[1]))
        line.peer = host, port
        return line
    except BaseException:
        device.close()
        raise


class _StreamLine(Line):
    """A stream of bytes, by TCP or a serial port; what the device does not take at once waits here."""

    def __init__(self, device: Any, endpoint: Endpoint, queue_request: int) -> None:
        super().__init__(device, endpoint)
        self._queue_request = queue_request
        self._waiting = bytearray()

    @property
    def busy(self) -> bool:
        queued = array.array("i", [0])  # bytes that the system has, and has not sent; 0 where it does not say
        with contextlib.suppress(OSError):
            fcntl.ioctl(self.fileno(), self._queue_request, queued)
        return len(self._waiting) + queued[0] > _BUSY

    def send(self, data: bytes) -> bool:
        if len(self._waiting) + len(data) > _BACKLOG:
            raise DeviceLost("the other end does not read")
        self._waiting += data
        self._flush()
        return True

    def _flush(self) -> None:
        try:
            while self._waiting:
                del self._waiting[: os.write(self.fileno(), self._waiting)]
        except (BlockingIOError, InterruptedError):
            return
        except OSError as error:
            raise DeviceLost(str(error)) from error

    def receive(self) -> list[tuple[bytes, Address]]:
        self._flush()
        try:
            if not select.select([self], [], [], 0.0)[0]:  # a serial port without data would look like one that is gone
                return []
            data = os.read(self.fileno(), _CHUNK)
        except (BlockingIOError, InterruptedError):
            return []
        except OSError as error:
            raise DeviceLost(str(error)) from error
        if not data:
            raise DeviceLost("there is nothing to read though it is ready: closed by the other end, or unplugged")
        return [(data, None)]


def open_line(endpoint: Endpoint, timeout: float) -> Line:
    try:
        if endpoint.transport is Transport.SERIAL:
            port = serial.Serial(endpoint.device, endpoint.baud, timeout=0, write_timeout=0, exclusive=True)
            return _StreamLine(port, endpoint, termios.TIOCOUTQ)
        if endpoint.transport is Transport.TCP:
            connection = socket.create_connection((endpoint.host, endpoint.port), timeout)
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return _StreamLine(connection, replace(endpoint, host=str(connection.getpeername()[0])), _NOT_SENT)
        return _udp_line(endpoint)
    except (OSError, ValueError, termios.error) as error:  # a device that goes again while it is opened: the last
        raise BackendError(f"cannot be opened: {error}", field="pixhawk.connection", given=str(endpoint)) from error
