"""Rate, jitter and cost of the servo bus over emulated servos in a process of their own.

Run it by hand: python tests/hardware/dynamixel/benchmark_servo_bus.py [seconds] [--sdk]
"""

from __future__ import annotations

import argparse
import multiprocessing
import time
from multiprocessing.connection import Connection

import numpy as np

from doorman.hardware.dynamixel import ServoBus, ServoConfig
from doorman.hardware.dynamixel.wire.telemetry import BLOCK_SIZE
from doorman.rig.emulators.servos import ServoEmulator


def emulate(channel: Connection, baud_rate: int) -> None:
    with ServoEmulator(baud_rate=baud_rate) as emulator:
        channel.send(emulator.port)
        channel.recv()


def benchmark_bus(port: str, seconds: float) -> None:
    config = ServoConfig(port, [-3.1, -1.65, -1.65, -1.8], [3.1, 1.65, 1.65, 1.8], [3.1] * 4)
    with ServoBus(config) as bus:
        start, cpu, calls = time.monotonic(), time.process_time(), []
        while (now := time.monotonic()) < start + seconds:
            rates = 0.5 * np.sin(now + np.arange(4.0))
            before = time.perf_counter()
            bus.read()
            bus.command(rates)
            calls.append(time.perf_counter() - before)
            time.sleep(0.004)
        share = (time.process_time() - cpu) / (time.monotonic() - start)
        statistics, events = bus.statistics, bus.events()
    print(f"cycles: {statistics.cycles / seconds:.1f} 1/s, overruns {statistics.overruns}, events {len(events)}")
    print(f"period [ms]: median {statistics.period_median * 1e3:.3f}, p99.9 {statistics.period_p999 * 1e3:.3f}, "
          f"max {statistics.period_max * 1e3:.3f}")  # fmt: skip
    print(f"read + command [µs]: median {np.median(calls) * 1e6:.0f}, p99.9 {np.percentile(calls, 99.9) * 1e6:.0f}")
    print(f"processor time: {100.0 * share:.1f} % of one core")


def benchmark_sdk(port: str, seconds: float) -> None:
    import dynamixel_sdk as sdk

    handler, packets = sdk.PortHandler(port), sdk.PacketHandler(2.0)
    handler.setBaudRate(1_000_000)
    reads = sdk.GroupSyncRead(handler, packets, 224, BLOCK_SIZE)
    for servo_id in (1, 2, 3, 4):
        reads.addParam(servo_id)
    start, cpu, times = time.monotonic(), time.process_time(), []
    while time.monotonic() < start + seconds:
        before = time.perf_counter()
        assert reads.txRxPacket() == sdk.COMM_SUCCESS
        times.append(time.perf_counter() - before)
        time.sleep(max(0.005 - times[-1], 0.0))
    share = (time.process_time() - cpu) / (time.monotonic() - start)
    handler.closePort()
    print(f"dynamixel-sdk GroupSyncRead [ms]: median {np.median(times) * 1e3:.2f}; reads only, at 200 1/s")
    print(f"processor time: {100.0 * share:.1f} % of one core")


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("seconds", nargs="?", type=float, default=10.0)
    parser.add_argument("--sdk", action="store_true", help="the same reads by dynamixel-sdk")
    arguments = parser.parse_args()
    ours, theirs = multiprocessing.get_context("spawn").Pipe()
    process = multiprocessing.get_context("spawn").Process(target=emulate, args=(theirs, 1_000_000), daemon=True)
    process.start()
    port = ours.recv()
    (benchmark_sdk if arguments.sdk else benchmark_bus)(port, arguments.seconds)
    ours.send("stop")
    process.join(5.0)


if __name__ == "__main__":
    main()
