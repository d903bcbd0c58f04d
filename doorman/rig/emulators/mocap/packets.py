"""Packets of the Vicon Tracker UDP object stream as Tracker makes them."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np

from doorman.arrays import Array

SIZES = (256, 512, 1024)
"""Sizes of packets [byte]; zeros fill what the items leave."""
_OBJECT_ID = 0
_BODY = struct.Struct("<24sdddddd")


def euler_xyz(rotation: Array) -> Array:
    """Angles (a, b, c) of R = Rx(a) Ry(b) Rz(c)."""
    return np.array(
        [
            np.arctan2(-rotation[1, 2], rotation[2, 2]),
            np.arcsin(np.clip(rotation[0, 2], -1.0, 1.0)),
            np.arctan2(-rotation[0, 1], rotation[0, 0]),
        ]
    )


def item(name: str, translation: Array, rotation: Array) -> bytes:
    """One tracked object."""
    body = _BODY.pack(name.encode(), *translation.tolist(), *rotation.tolist())
    return struct.pack("<BH", _OBJECT_ID, len(body)) + body


def packet(frame_number: int, items: Sequence[bytes], size: int | None = SIZES[0]) -> bytes:
    content = struct.pack("<IB", frame_number % (1 << 32), len(items)) + b"".join(items)
    if size is None:
        return content
    return content.ljust(min((fit for fit in SIZES if fit >= max(size, len(content))), default=len(content)), b"\0")
