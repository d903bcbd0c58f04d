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


_SCHEMES = {
    "udp": Transport.UDP_LISTEN,
    "udpin": Transport.UDP_LISTEN,
    "udpout": Transport.UDP_SEND,
    "tcp": Transport.TCP,
    "serial": Transport.SERIAL,
}
_NETWORK = re.compile(r"(?:([A-Za-z0-9.-]*):)?([0-9]+)(?::([0-9]+))?")
"""Host, port, and our own port."""
_SERIAL = re.compile(r"(.+?)(?::([0-9]+))?")
"""Device and baud rate."""
_PORTS, _BAUDS = range(1, 65536), range(1200, 12_000_001)


def parse_connection(text: str) -> Endpoint:
    # `udp:` listens, on loopback unless a host is written: `udp:14540`, `udp:0.0.0.0:14540`. `udpout:` and `tcp:` call
    # an autopilot that listens; `udpout:` may name the port to send from, since PX4 answers only the first caller until
    # it is rebooted. `://` may stand for the first colon. A serial device is a path or a COM port.
    given = text.strip()
    scheme, _, rest = given.replace("://", ":", 1).partition(":")
    kind = _SCHEMES.get(scheme.lower())
    if kind is None and re.match(r"/|COM\d", given):
        kind, rest = Transport.SERIAL, given
    if kind is Transport.SERIAL and (found := _SERIAL.fullmatch(rest)):
        baud = int(found[2] or DEFAULT_BAUD)
        if baud in _BAUDS:
            return Endpoint(kind, device=found[1], baud=baud)
    elif kind is not None and (found := _NETWORK.fullmatch(rest)):
        host, port, own = found[1] or "", int(found[2]), found[3]
        ours = own is None or (kind is Transport.UDP_SEND and int(own) in _PORTS)
        if port in _PORTS and ours and (host or kind is Transport.UDP_LISTEN):
            return Endpoint(kind, host or LOOPBACK, port, own_port=int(own or 0))
    raise BackendError("not a connection string", field="pixhawk.connection", given=text, allowed=ALLOWED)
