"""Client of other cameras, as a process of its own: `python -m` of this module, with KIND PORT RATE KEY=VALUE….

The wheel `motioncapture` speaks to the cameras. It connects without a time-out and cannot be interrupted, and a frame that it
misreads may end the process: so it runs apart from whatever flies. It tells neither frame numbers nor times; `PoseSender` numbers
frames by when they come.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from collections.abc import Mapping
from typing import Any, Protocol

from doorman.hardware.mocap.sources.sender import PoseSender

_DIE_WITH_PARENT = 1
"""PR_SET_PDEATHSIG."""
STATELESS = ("vrpn",)
"""Kinds that return at their own pace, with or without a new pose."""


class Cameras(Protocol):
    rigidBodies: Mapping[str, Any]  # noqa: N815  # the wheel's name

    def waitForNextFrame(self) -> None:  # noqa: N802
        """Block until the next frame."""


def relay(cameras: Cameras, sender: PoseSender, stateless: bool) -> None:
    cameras.waitForNextFrame()
    poses = {}
    for name, body in cameras.rigidBodies.items():
        x, y, z = (float(value) for value in body.position)
        turn = body.rotation
        poses[name] = (x, y, z), (float(turn.w), float(turn.x), float(turn.y), float(turn.z))
    if poses or not stateless:
        sender.send(poses)


def main(arguments: list[str]) -> None:
    kind, port, rate, *settings = arguments
    parent = os.getppid()
    ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL)
    if os.getppid() != parent:  # it ended before
        return
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C of the terminal is the flight's to answer
    import motioncapture

    cameras = motioncapture.connect(kind, dict(one.split("=", 1) for one in settings))
    with PoseSender(("127.0.0.1", int(port)), float(rate)) as sender:
        while True:
            relay(cameras, sender, kind in STATELESS)


if __name__ == "__main__":
    main(sys.argv[1:])
