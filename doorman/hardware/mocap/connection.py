"""Where the stream is received: a checked string and the socket that listens there."""

from __future__ import annotations

import re
import socket

from doorman.exceptions import BackendError

LOOPBACK = "127.0.0.1"
RECEIVE_BUFFER = 1 << 18
"""About a second of the stream's largest packets [byte]."""
_ALLOWED = "udp:[HOST:]PORT; loopback unless a host is written"


def parse_connection(text: str) -> tuple[str, int]:
    """Address to listen on.

    `udp:51001` listens on loopback, `udp:192.168.1.7:51001` on that interface, `udp:0.0.0.0:51001` on all, which broadcasts
    need.

    Args:
        text: The string; `://` may stand for the first colon.

    Returns:
        Host and port; nothing is opened.

    Raises:
        BackendError: if it is malformed.
    """
    found = re.fullmatch(r"udp:(?://)?(?:([A-Za-z0-9.-]+):)?(\d{1,5})", text.strip(), re.ASCII)
    if found is None or not 0 < int(found[2]) < 65536:
        raise BackendError("not an address to listen on", field="mocap.connection", given=text, allowed=_ALLOWED)
    return found[1] or LOOPBACK, int(found[2])


def listen(connection: str) -> socket.socket:
    """Socket that receives the stream and never blocks.

    Args:
        connection: As for `parse_connection`.

    Raises:
        BackendError: if the address is not this computer's, or is taken.
    """
    host, port = parse_connection(connection)
    channel = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        channel.setblocking(False)
        channel.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        channel.bind((host, port))
    except OSError as error:
        channel.close()
        raise BackendError(f"cannot listen: {error.strerror or error}", field="mocap.connection", given=connection,
                           allowed="an address of this computer, and a port that nobody uses") from error  # fmt: skip
    return channel
