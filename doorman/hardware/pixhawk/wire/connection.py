"""Connection strings: where the autopilot is found, checked before any device is touched."""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum

from doorman.exceptions import BackendError

LOOPBACK = "127.0.0.1"
DEFAULT_BAUD = 921_600
ALLOWED = "udp:[HOST:]PORT (listen), udpout:HOST:PORT[:OURS], tcp:HOST:PORT, serial:DEVICE[:BAUD] or /dev/...[:BAUD]"


class Transport(Enum):
    UDP_LISTEN = "udpin"
    UDP_SEND = "udpout"
    TCP = "tcp"
    SERIAL = "serial"


@dataclass(frozen=True)
class Endpoint:
    transport: Transport
    host: str = ""
    port: int = 0
    device: str = ""
    baud: int = DEFAULT_BAUD
    own_port: int = 0  # to send from; 0 leaves it to the system

    def __str__(self) -> str:
        if self.transport is Transport.SERIAL:
            return f"serial:{self.device}:{self.baud}"
        own = f":{self.own_port}" if self.own_port else ""
        return f"{self.transport.value}:{self.host}:{self.port}{own}"


def parse_connection(text: str) -> Endpoint:
    # `udp:` listens, on loopback unless a host is written: `udp:14540`, `udp:0.0.0.0:14540`. `udpout:` and `tcp:` call
    # an autopilot that listens; `udpout:` may name the port to send from, since PX4 answers only the first caller until
    # it is rebooted. `://` may stand for the first colon. A serial device is a path or a COM port.
    given = text.strip()
    scheme, _, rest = given.replace("://", ":", 1).partition(":")
    kinds = {
        "udp": Transport.UDP_LISTEN,
        "udpin": Transport.UDP_LISTEN,
        "udpout": Transport.UDP_SEND,
        "tcp": Transport.TCP,
        "serial": Transport.SERIAL,
    }
    kind = kinds.get(scheme.lower())
    if kind is None and re.match(r"(/dev/|/|COM\d)", given):
        kind, rest = Transport.SERIAL, given
    if kind is None or not rest:
        raise _malformed("not a connection string", text)
    return _serial(rest, text) if kind is Transport.SERIAL else _network(kind, rest, text)


def _network(kind: Transport, rest: str, text: str) -> Endpoint:
    own_port = 0
    if kind is Transport.UDP_SEND and rest.count(":") == 2:
        rest, _, own_text = rest.rpartition(":")
        own_port = _port(own_text, text)
    host, _, port_text = rest.rpartition(":")
    port = _port(port_text, text)
    if host and not re.fullmatch(r"[A-Za-z0-9.-]+", host):
        raise _malformed("no valid host", text)
    if not host and kind is not Transport.UDP_LISTEN:
        raise _malformed("no host to call", text)
    return Endpoint(kind, host or LOOPBACK, port, own_port=own_port)


def _port(digits: str, text: str) -> int:
    if not digits.isascii() or not digits.isdigit() or not 0 < int(digits) < 65536:
        raise _malformed("no valid port", text)
    return int(digits)


def _serial(rest: str, text: str) -> Endpoint:
    device, colon, baud_text = rest.rpartition(":")
    if not colon or not baud_text.isdigit():
        device, baud_text = rest, str(DEFAULT_BAUD)
    if not device or not 1200 <= int(baud_text) <= 12_000_000:
        raise _malformed("no valid device or baud rate", text)
    return Endpoint(Transport.SERIAL, device=device, baud=int(baud_text))


def _malformed(message: str, text: str) -> BackendError:
    return BackendError(message, field="pixhawk.connection", given=text, allowed=ALLOWED)
