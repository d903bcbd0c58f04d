"""MAVLink frames in and out of bytes, by pymavlink's messages; whatever arrives, nothing is raised and nothing hangs.

MAVLink signing: the key from a file, and the check of received signatures.

A signature is the first 48 bits of SHA-256 over key, packet, link id and time stamp, in units of 10 µs since 2015
(MAVLink's guide on message signing).
"""

from __future__ import annotations

import hashlib
import hmac
import os
import stat
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk.wire.messages import Message, mavlink

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
    return int((time.time() - _EPOCH_2015) * _TICKS_PER_SECOND)


_STARTS = _START_V1, _START_V2 = 0xFE, 0xFD
_SIGNED = 0x01
_SIGNATURE_BYTES = 13


@dataclass
class Counters:
    """What came in, since the link was opened."""

    messages: int = 0
    corrupted: int = 0
    """Frames of a kind that is read that are not whole: of others an autopilot may have another definition than we."""
    bad_signatures: int = 0
    malformed: int = 0  # frames with a right checksum that cannot be decoded


class _Header(NamedTuple):
    length: int  # of the whole frame
    identifier: int  # of the message
    sender: tuple[int, int]  # system and component
    flags: int

    @property
    def end(self) -> int:
        """Bytes of the frame behind its payload: checksum, and signature."""
        return 2 + (_SIGNATURE_BYTES if self.flags & _SIGNED else 0)


def _header(data: bytearray) -> _Header | None:
    """What a frame begins with; None while that is incomplete."""
    if data[0] == _START_V1:
        return _Header(data[1] + 8, data[5], (data[3], data[4]), 0) if len(data) >= 6 else None
    if len(data) < 10:
        return None
    signature = _SIGNATURE_BYTES if data[2] & _SIGNED else 0
    return _Header(data[1] + 12 + signature, int.from_bytes(data[7:10], "little"), (data[5], data[6]), data[2])


def _whole(header: _Header, frame: bytearray) -> bool:
    kind = mavlink.mavlink_map.get(header.identifier)
    if kind is None or header.flags & ~_SIGNED:
        return False
    body = frame[1 : -header.end]
    body.append(kind.crc_extra)
    return bool(mavlink.x25crc(body).crc == int.from_bytes(frame[-header.end :][:2], "little"))


class FrameSplitter:
    """Cuts a stream of bytes into frames with a right checksum."""

    # After a wrong one it looks on at the next byte, so that a damaged length swallows no good frame. One of a kind that is not
    # read may be right by another definition than ours: it is passed over where the next frame begins at its end.

    def __init__(self, counters: Counters, read: frozenset[int]) -> None:
        self._buffer = bytearray()
        self._counters = counters
        self._read = read

    def push(self, data: bytes) -> Iterator[tuple[_Header, bytearray]]:
        """Take bytes and yield the frames that they complete."""
        buffer, start = self._buffer, 0
        buffer += data
        while start < len(buffer):
            if buffer[start] not in _STARTS:
                start += 1
                continue
            header = _header(buffer[start : start + 10])
            if header is None or (end := start + header.length) > len(buffer):
                break  # the rest is still to come
            frame = buffer[start:end]
            if _whole(header, frame):
                start = end
                yield header, frame
            elif header.identifier in self._read:
                self._counters.corrupted += 1
                start += 1
            elif end == len(buffer):
                break  # what follows will tell
            else:
                start = end if buffer[end] in _STARTS else start + 1
        del buffer[:start]


class Codec:
    def __init__(self, system_id: int, component_id: int, key: bytes | None, wanted: frozenset[int]) -> None:
        self.counters = Counters()
        self.outdated = False
        """Whether somebody with the key has sent old stamps only: a newer one of ours sets its clock."""
        self._wanted, self._key = wanted, key
        self._mav = mavlink.MAVLink(None, system_id, component_id)
        self._newest: dict[tuple[int, int, int], int] = {}  # stamp by stream
        self._splitters: dict[object, FrameSplitter] = {}
        if key is not None:
            signing = self._mav.signing
            signing.secret_key, signing.sign_outgoing, signing.link_id = key, True, 0
            self._mav.check_signature = lambda packet, system, component: True  # checked before decoding

    def encode(self, message: Message) -> bytes:
        if self._key is not None:
            self._mav.signing.timestamp = max(self._mav.signing.timestamp, signing_time())
        data: bytes = message.pack(self._mav)
        self._mav.seq = (self._mav.seq + 1) % 256
        return data

    def decode(self, data: bytes, source: object) -> list[Message]:
        """Messages of interest that some bytes complete; every source has its own stream."""
        if source not in self._splitters:
            if len(self._splitters) >= 16:  # strangers must not fill the memory
                self._splitters.clear()
            self._splitters[source] = FrameSplitter(self.counters, self._wanted)
        messages = (self._message(header, frame) for header, frame in self._splitters[source].push(data))
        return [message for message in messages if message is not None]

    def _message(self, header: _Header, frame: bytearray) -> Message | None:
        if self._key is not None and not self._signed(self._key, header, frame):
            self.counters.bad_signatures += 1
            return None
        self.counters.messages += 1
        if header.identifier not in self._wanted:
            return None
        try:
            return self._mav.decode(frame)
        except Exception:  # noqa: BLE001  # whatever pymavlink stumbles over, the frame is worth nothing
            self.counters.malformed += 1
            return None

    def _signed(self, key: bytes, header: _Header, frame: bytearray) -> bool:
        """Whether the signature is right, and the stamp in it newer than the last one."""
        # The stamp is looked at only after the signature has been verified: a forged one must not shut out the real stream.
        expected = hashlib.sha256(key + frame[:-6]).digest()[:6]
        if not header.flags & _SIGNED or not hmac.compare_digest(expected, bytes(frame[-6:])):
            return False
        stamp, stream = int.from_bytes(frame[-12:-6], "little"), (frame[-13], *header.sender)
        if stamp <= self._newest.get(stream, signing_time() - _NEW_STREAM_WINDOW):
            self.outdated = True
            return False
        self._newest[stream] = stamp
        self._mav.signing.timestamp = max(self._mav.signing.timestamp, stamp)  # ours must not be older
        return True
