"""Time from a datagram's leaving to the pose in a waiting reader, through every source that can be emulated here, on loopback.

Run it by hand: python tests/hardware/mocap/sources/benchmark_sources.py [seconds]
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from mocap_rig import free_port

from doorman.hardware.mocap import MocapConfig, MocapReceiver
from doorman.rig.emulators.mocap.emulator import BodyPose, MocapEmulator, TrackerSetup
from doorman.rig.emulators.mocap.natnet import NatNetBody, NatNetEmulator

STEP = 1e-4
"""Along x from frame to frame [m]: the pose says which frame it is of."""


class Marked:
    """A pose that says which it is, and when it was made."""

    def __init__(self) -> None:
        self.made: list[float] = []

    def __call__(self, _: float) -> BodyPose:
        self.made.append(time.monotonic())
        return BodyPose((STEP * len(self.made), 0.0, 1.0))


def tracker(pose: Marked) -> tuple[AbstractContextManager[object], str]:
    port = free_port()
    setup = TrackerSetup("vehicle", latency=0.0, position_noise=0.0, attitude_noise=0.0)
    return MocapEmulator(pose, setup, ("127.0.0.1", port)), f"udp:{port}"


def optitrack(pose: Marked) -> tuple[AbstractContextManager[object], str]:
    port = free_port()
    return NatNetEmulator([NatNetBody("vehicle", 1, pose)], port, free_port()), f"optitrack:127.0.0.1:{port}"


def measure(source: Callable[[Marked], tuple[AbstractContextManager[object], str]], seconds: float) -> np.ndarray:
    pose = Marked()
    emulator, connection = source(pose)
    times = []
    with emulator, MocapReceiver(MocapConfig("vehicle", connection, latency=0.0)) as receiver:
        sample, end = receiver.read(), time.monotonic() + seconds
        while time.monotonic() < end:
            sample = receiver.wait(sample, 1.0)
            times.append(time.monotonic() - pose.made[round(sample.position[0] / STEP) - 1])
    return 1e3 * np.array(times)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("seconds", nargs="?", type=float, default=10.0)
    seconds = parser.parse_args().seconds
    for source in (tracker, optitrack):
        times = measure(source, seconds)
        median, late = np.percentile(times, (50.0, 99.0))
        print(
            f"{source.__name__:10s} {len(times)} poses: median {median:.2f} ms, p99 {late:.2f} ms, most {times.max():.2f} ms"
        )


if __name__ == "__main__":
    main()
