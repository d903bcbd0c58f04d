"""MAVLink signing: the key from a file, and the check of received signatures.

A signature is the first 48 bits of SHA-256 over key, packet, link id and time stamp, in units of 10 µs since 2015
(MAVLink's guide on message signing).
"""

from __future__ import annotations

import hashlib
import hmac
import os
import stat
import time
from pathlib import Path

from doorman.exceptions import BackendError

KEY_BYTES = 32
_EPOCH_2015 = 1_420_070_400
_TICKS_PER_SECOND = 100_000
_NEW_STREAM_WINDOW = 60 * _TICKS_PER_SECOND
"""A stream that is heard for the first time may lag this much."""


def load_key(path: str | Path) -> bytes:
    file = Path(path)
    try:
        with file.open("rb") as stream:
            mode = os.fstat(stream.fileno()).st_mode
            content = stream.read(4 * KEY_BYTES)
    except OSError as error:
        raise BackendError(f"the signing key cannot be read: {error.strerror}", file=file) from error
    if os.name == "posix" and mode & (stat.S_IRWXG | stat.S_IRWXO):
        raise BackendError("others may read the signing key", file=file, given=oct(mode & 0o777), allowed="mode 0600")
    if len(content) == KEY_BYTES:
        return content
    try:
        key = bytes.fromhex(content.decode("ascii").strip())
    except ValueError:
        key = b""
    if len(key) != KEY_BYTES:
        raise BackendError("not a signing key", file=file, allowed="32 bytes, or 64 hexadecimal digits")
    return key


def signing_time() -> int:
    """Time stamp of a signature now, by the wall clock."""
    return int((time.time() - _EPOCH_2015) * _TICKS_PER_SECOND)


class SignatureCheck:
    def __init__(self, key: bytes) -> None:
        self._key = key
        self._newest: dict[tuple[int, int, int], int] = {}
        self.newest = 0  # newest stamp of any that was accepted: ours must not be older
        self.outdated = False  # whether the last packet had the right key, and an old stamp

    def accepts(self, packet: bytes | bytearray, system: int, component: int) -> bool:
        """Whether a signed packet is genuine and new."""
        # The stamp is looked at only after the signature has been verified: a forged one must not shut out the real stream.
        self.outdated = False
        expected = hashlib.sha256(self._key + bytes(packet[:-6])).digest()[:6]
        if not hmac.compare_digest(expected, bytes(packet[-6:])):
            return False
        stamp = int.from_bytes(packet[-12:-6], "little")
        stream = (packet[-13], system, component)
        oldest = self._newest.get(stream, signing_time() - _NEW_STREAM_WINDOW)
        if stamp <= oldest:
            self.outdated = True
            return False
        self._newest[stream] = stamp
        self.newest = max(self.newest, stamp)
        return True
