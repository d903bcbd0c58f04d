"""Where poses come from: a checked string, the socket that receives the stream, and the process of a cameras' client."""

from __future__ import annotations

import re
import socket
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from types import MappingProxyType
from typing import IO, NamedTuple

from doorman.clocks import RESTART
from doorman.exceptions import BackendError

LOOPBACK = "127.0.0.1"
RECEIVE_BUFFER = 1 << 18
"""About a second of the stream's largest packets [byte]."""
KINDS = MappingProxyType({"optitrack": "port_command", "qualisys": "port", "vicon": "", "vrpn": ""})
"""Cameras that the extra `mocap` speaks to, and the setting that takes their port; nothing where it stays with the host."""
_PATTERN = rf"({'|'.join(KINDS)}):(?://)?([A-Za-z0-9.-]+)(?::(\d{{1,5}}))?((?:,\w+=[\w.:-]+)*)"
_ALLOWED = (
    "udp:[HOST:]PORT; loopback unless a host is written; "
    f"or KIND:HOST[:PORT][,KEY=VALUE...] with KIND {', '.join(KINDS)}"
)


class CamerasLink(NamedTuple):
    kind: str  # one of `KINDS`
    settings: Mapping[str, str]  # as the wheel `motioncapture` takes them


def parse_cameras(text: str) -> CamerasLink | None:
    found = re.fullmatch(_PATTERN, text.strip(), re.ASCII)
    if found is None or not 0 < int(found[3] or 1) < 65536:
        return None
    kind, host, port, rest = found.groups()
    name = KINDS[kind]
    hostname = host if name or port is None else f"{host}:{port}"
    settings = {"hostname": hostname} | ({name: port} if name and port else {})
    settings |= dict(one.split("=", 1) for one in rest.split(",") if one)
    return CamerasLink(kind, MappingProxyType(settings))


def parse_connection(text: str) -> tuple[str, int]:
    """Address to listen on; for cameras with a client, any free port of loopback."""
    if parse_cameras(text) is not None:
        return LOOPBACK, 0
    found = re.fullmatch(r"udp:(?://)?(?:([A-Za-z0-9.-]+):)?(\d{1,5})", text.strip(), re.ASCII)
    if found is None or not 0 < int(found[2]) < 65536:
        raise BackendError("not an address to listen on", field="mocap.connection", given=text, allowed=_ALLOWED)
    return found[1] or LOOPBACK, int(found[2])


def listen(connection: str) -> socket.socket:
    """Socket that receives the stream and never blocks."""
    address = parse_connection(connection)
    channel = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        channel.setblocking(False)
        channel.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        channel.bind(address)
    except OSError as error:
        channel.close()
        raise BackendError(f"cannot listen: {error.strerror or error}", field="mocap.connection", given=connection,
                           allowed="an address of this computer, and a free port") from error  # fmt: skip
    return channel


_KEPT = 300
"""Characters of its last words that are kept."""


class ClientProcess:
    """Runs the client from its making until `close`; ends with the thread that made it."""

    def __init__(self, link: CamerasLink, port: int, rate: float) -> None:
        self._words: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115  # open as long as the process
        module = "doorman.hardware.mocap.sources.client"
        settings = [f"{key}={value}" for key, value in link.settings.items()]
        self._process = subprocess.Popen(
            [sys.executable, "-m", module, link.kind, str(port), repr(rate), *settings],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=self._words,
        )  # fmt: skip

    @property
    def last_words(self) -> str | None:
        """Why it has ended; None while it runs."""
        code = self._process.poll()
        if code is None:
            return None
        self._words.seek(0)
        lines = self._words.read().decode(errors="replace").strip().splitlines()
        return (lines[-1] if lines else f"it ended with status {code}")[:_KEPT]

    def close(self) -> None:
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait(RESTART)
        self._words.close()
