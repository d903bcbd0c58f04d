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


class SignatureCheck:
    def __init__(self, key: bytes) -> None:
        self._key = key
        self._newest: dict[tuple[int, int, int], int] = {}
        self.newest = 0  # newest stamp of any that was accepted: ours must not be older
        self.outdated = False  # whether the last packet had the right key, and an old stamp

    def accepts(self, packet: bytes | bytearray, system: int, component: int) -> bool:
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


_STARTS = _START_V1, _START_V2 = 0xFE, 0xFD
_SIGNED = 0x01
_SIGNATURE_BYTES = 13


@dataclass
class Counters:
    """What came in, since the link was opened."""

    messages: int = 0
    corrupted: int = 0
    """Frames of a kind that is read whose checksum is wrong: of others an autopilot may have another definition than we."""
    skipped_bytes: int = 0  # bytes that belong to no valid frame
    bad_signatures: int = 0
    malformed: int = 0  # frames with a right checksum that cannot be decoded


class FrameSplitter:
    """Cuts a stream of bytes into frames with a right checksum."""

    # After a wrong one it looks on at the next byte, so that a damaged length swallows no good frame. One of a kind that is not
    # read may be right by another definition than ours: it is passed over where the next frame begins at its end.

    def __init__(self, counters: Counters, read: frozenset[int]) -> None:
        self._buffer = bytearray()
        self._counters = counters
        self._read = read

    def push(self, data: bytes) -> Iterator[bytearray]:
        """Take bytes and yield the frames that they complete."""
        buffer = self._buffer
        buffer += data
        start = 0
        while start < len(buffer):
            if buffer[start] not in _STARTS:
                start += 1
                self._counters.skipped_bytes += 1
                continue
            length = _frame_length(buffer, start)
            if length == 0 or start + length > len(buffer):
                break  # the rest is still to come
            frame = buffer[start : start + length]
            if self._valid(frame):
                start += length
                yield frame
            else:
                end = start + length
                unread = not self._is_read(frame)
                if unread and end == len(buffer):
                    break  # what follows will tell
                whole = unread and buffer[end] in _STARTS
                self._counters.skipped_bytes += length if whole else 1
                start += length if whole else 1
        del buffer[:start]

    def _is_read(self, frame: bytearray) -> bool:
        return _identifier(frame) in self._read

    def _valid(self, frame: bytearray) -> bool:
        second = frame[0] == _START_V2
        identifier = _identifier(frame)
        if second and frame[2] & ~_SIGNED:
            return False
        kind = mavlink.mavlink_map.get(identifier)
        if kind is None:
            return False
        end = 2 + (_SIGNATURE_BYTES if second and frame[2] & _SIGNED else 0)
        body = frame[1:-end]
        body.append(kind.crc_extra)
        right = bool(mavlink.x25crc(body).crc == int.from_bytes(frame[-end:][:2], "little"))
        self._counters.corrupted += not right and self._is_read(frame)
        return right


def _frame_length(buffer: bytearray, start: int) -> int:
    """Length of the frame that begins at `start`; 0 while its header is incomplete."""
    if len(buffer) - start < 3:
        return 0
    payload = buffer[start + 1]
    if buffer[start] == _START_V1:
        return payload + 8
    return payload + 12 + (_SIGNATURE_BYTES if buffer[start + 2] & _SIGNED else 0)


def _identifier(frame: bytearray) -> int:
    return int.from_bytes(frame[7:10], "little") if frame[0] == _START_V2 else frame[5]


class Codec:
    def __init__(self, system_id: int, component_id: int, key: bytes | None, wanted: frozenset[int]) -> None:
        self.counters = Counters()
        self.outdated = False
        """Whether somebody with the key has sent old stamps only: a newer one of ours sets its clock."""
        self._wanted = wanted
        self._mav = mavlink.MAVLink(None, system_id, component_id)
        self._check = None if key is None else SignatureCheck(key)
        self._splitters: dict[object, FrameSplitter] = {}
        if key is not None:
            signing = self._mav.signing
            signing.secret_key, signing.sign_outgoing, signing.link_id = key, True, 0
            signing.timestamp = signing_time()
            self._mav.check_signature = lambda packet, system, component: True  # checked before decoding

    def encode(self, message: Message) -> bytes:
        if self._check is not None:
            self._mav.signing.timestamp = max(self._mav.signing.timestamp, signing_time(), self._check.newest)
        data: bytes = message.pack(self._mav)
        self._mav.seq = (self._mav.seq + 1) % 256
        return data

    def decode(self, data: bytes, source: object) -> list[Message]:
        """Messages of interest that some bytes complete; every source has its own stream."""
        if source not in self._splitters:
            if len(self._splitters) >= 16:  # strangers must not fill the memory
                self._splitters.clear()
            self._splitters[source] = FrameSplitter(self.counters, self._wanted)
        messages = (self._message(frame) for frame in self._splitters[source].push(data))
        return [message for message in messages if message is not None]

    def _message(self, frame: bytearray) -> Message | None:
        second = frame[0] == _START_V2
        identifier = _identifier(frame)
        if self._check is not None:
            system, component = (frame[5], frame[6]) if second else (frame[3], frame[4])
            signed = second and bool(frame[2] & _SIGNED)
            if not signed or not self._check.accepts(frame, system, component):
                self.counters.bad_signatures += 1
                self.outdated = self.outdated or (signed and self._check.outdated)
                return None
        self.counters.messages += 1
        if identifier not in self._wanted:
            return None
        try:
            return self._mav.decode(frame)
        except Exception:  # noqa: BLE001  # whatever pymavlink stumbles over, the frame is worth nothing
            self.counters.malformed += 1
            return None
