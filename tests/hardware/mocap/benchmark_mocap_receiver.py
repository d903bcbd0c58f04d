"""Rate, delays and cost of the receiver over an emulated Tracker in a process of its own.

Run it by hand: python tests/hardware/mocap/benchmark_mocap_receiver.py [seconds] [rate]
"""

from __future__ import annotations

import argparse
import multiprocessing
import time
from multiprocessing.connection import Connection

import numpy as np
from mocap_rig import NAME, free_port, swaying, true_position

from doorman.hardware.mocap import MocapConfig, MocapReceiver
from doorman.rig.emulators.mocap.emulator import MocapEmulator, TrackerSetup


def emulate(channel: Connection, port: int, rate: float) -> None:
    with MocapEmulator(swaying, TrackerSetup(NAME, rate=rate), ("127.0.0.1", port)):
        channel.recv()


def benchmark(port: int, rate: float, seconds: float) -> None:
    config = MocapConfig(NAME, f"udp:{port}", rate=rate)
    with MocapReceiver(config) as receiver:
        receiver.events()
        start, cpu, calls, rows = time.monotonic(), time.process_time(), [], []
        while time.monotonic() < start + seconds:
            before = time.perf_counter()
            rows.append(receiver.read())
            calls.append(time.perf_counter() - before)
            time.sleep(0.004)
        share = (time.process_time() - cpu) / (time.monotonic() - start)
        figures, events = receiver.statistics, receiver.events()
    errors = [np.linalg.norm(one.position - true_position(one.time)) for one in rows]
    print(f"poses: {figures.poses} of {figures.frames} frames, {figures.frame_rate:.3f} 1/s; events {len(events)}")
    print(f"interval [ms]: median {1e3 * figures.interval:.3f}, jitter {1e3 * figures.jitter:.3f}")
    print(f"delay [ms]: median {1e3 * figures.delay:.3f}, p99 {1e3 * figures.delay_p99:.3f}, "
          f"max {1e3 * figures.delay_max:.3f}")  # fmt: skip
    print(f"age at read [ms]: median {1e3 * np.median([one.age for one in rows]):.1f}; "
          f"fresh {100.0 * np.mean([one.fresh for one in rows]):.2f} %")  # fmt: skip
    print(f"position against the truth at the stamp [mm]: median {1e3 * np.median(errors):.2f}")
    print(f"velocity lag [ms]: {1e3 * figures.velocity_lag:.1f}")
    print(f"read [µs]: median {np.median(calls) * 1e6:.0f}, p99 {np.percentile(calls, 99.0) * 1e6:.0f}")
    print(f"processor time: {100.0 * share:.1f} % of one core")


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("seconds", nargs="?", type=float, default=10.0)
    parser.add_argument("rate", nargs="?", type=float, default=100.0)
    arguments = parser.parse_args()
    port = free_port()
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=emulate, args=(theirs, port, arguments.rate), daemon=True)
    process.start()
    benchmark(port, arguments.rate, arguments.seconds)
    ours.send("stop")
    process.join(5.0)


if __name__ == "__main__":
    main()
