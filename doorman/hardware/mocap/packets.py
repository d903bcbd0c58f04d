"""Packets of the Vicon Tracker UDP object stream, little endian: frame number, number of items, items.

An item is id (uint8), size of what follows (uint16), name (24 bytes), translation (3 float64) [mm] and rotation (3 float64)
[rad]. Tracker pads packets to 256, 512 or 1024 bytes; what follows the last item means nothing.

`PoseSender` has items of its own: each says of one frame that it was refused before it came here, and why.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import NamedTuple

from doorman.hardware.mocap.faults import MocapFault

Vector = tuple[float, float, float]

LARGEST = 65536
"""Longer than any datagram [byte]."""
OBJECT_ITEM = 0
"""Id of items that are tracked objects."""
REFUSED_ITEM = 255
"""Id of items that say what was refused: one byte, an index of `REFUSALS`."""
REFUSALS = (MocapFault.FOREIGN, MocapFault.CORRUPT)
"""Why a sender refuses frames."""
MOST_ITEMS = 255
"""Most items of a packet."""
NAME_SIZE = 24
_HEADER = struct.Struct("<IB")
_ITEM = struct.Struct("<BH")
_OBJECT = struct.Struct(f"<{NAME_SIZE}s6d")


class TrackedObject(NamedTuple):
    name: str
    translation: Vector  # in Vicon's axes [mm]
    rotation: Vector  # about x, y' and z'' [rad]


class ObjectPacket(NamedTuple):
    """Content of one datagram; a frame may take several."""

    frame_number: int  # modulo 2³²
    objects: tuple[TrackedObject, ...]
    refused: tuple[MocapFault, ...] = ()  # why the sender has refused frames since its last packet, once for each


def parse(datagram: bytes) -> ObjectPacket | str:
    """Content of a datagram, or why it is no packet of the object stream."""
    if len(datagram) < _HEADER.size:
        return f"{len(datagram)} bytes are no packet"
    frame_number, items = _HEADER.unpack_from(datagram)
    objects, refused = [], []
    offset = _HEADER.size
    for index in range(items):
        which = f"item {index + 1} of {items}"
        if offset + _ITEM.size > len(datagram):
            return f"ends before {which}"
        kind, size = _ITEM.unpack_from(datagram, offset)
        offset += _ITEM.size
        if offset + size > len(datagram):
            return f"ends inside {which}"
        if kind == OBJECT_ITEM:
            if size != _OBJECT.size:
                return f"{which} is no object: {size} bytes"
            name, x, y, z, about_x, about_y, about_z = _OBJECT.unpack_from(datagram, offset)
            text = name.split(b"\0", 1)[0].decode("utf-8", "replace")
            objects.append(TrackedObject(text, (x, y, z), (about_x, about_y, about_z)))
        elif kind == REFUSED_ITEM and size == 1 and datagram[offset] < len(REFUSALS):
            refused.append(REFUSALS[datagram[offset]])
        offset += size
    return ObjectPacket(frame_number, tuple(objects), tuple(refused))


def pack(frame_number: int, objects: Sequence[TrackedObject], refused: Sequence[MocapFault] = ()) -> bytes:
    """A datagram with objects, as Tracker would send it without padding."""
    items = [
        _ITEM.pack(OBJECT_ITEM, _OBJECT.size) + _OBJECT.pack(one.name.encode(), *one.translation, *one.rotation)
        for one in objects
    ]
    items += [_ITEM.pack(REFUSED_ITEM, 1) + bytes([REFUSALS.index(fault)]) for fault in refused]
    return _HEADER.pack(frame_number % (1 << 32), len(items)) + b"".join(items)
