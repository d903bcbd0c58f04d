"""The bridge at 200 messages a second: how many of 10⁴ are lost on the way to an independent participant, and what a feed costs.

Run it by hand: python tests/ros2/benchmark_ros2.py [count]
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from doorman import Model, Scenario
from doorman.ros2 import Feed

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1] / "helpers")]
from test_ros2 import INDEPENDENT, LOOPBACK, NAMES, dds_name, free_port, measurement  # noqa: E402

DOMAIN = 201


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("count", nargs="?", type=int, default=10_000)
    count, port = parser.parse_args().count, free_port()
    Model(Scenario.load("paper"))
    os.environ["CYCLONEDDS_URI"] = LOOPBACK
    command = [sys.executable, "-m", "doorman", "ros2", "paper", "--feed", str(port), "--domain", str(DOMAIN)]
    hear = [
        sys.executable,
        str(INDEPENDENT),
        "listen",
        str(DOMAIN),
        NAMES["odometry"],
        dds_name("doorman/odometry"),
        str(count),
    ]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as bridge, Feed(port) as feed:
        assert bridge.stdout
        bridge.stdout.readline()
        heard = tempfile.TemporaryFile()  # noqa: SIM115  # a pipe would fill
        listener = subprocess.Popen(hear, stdout=heard)
        time.sleep(4.0)
        costs, start = [], time.monotonic()
        for index in range(count):
            time.sleep(max(start + 0.005 * index - time.monotonic(), 0.0))
            before = time.perf_counter()
            feed.listen("measurement", 0.005 * index, measurement(index))
            costs.append(time.perf_counter() - before)
        listener.wait()
        heard.seek(0)
        lost = count + 1 - len(heard.readlines())  # the first line says that it is ready
        bridge.terminate()
        bridge.communicate()
    median, late = 1e6 * np.percentile(costs, (50.0, 99.0))
    print(f"{lost} of {count} lost; a message costs the flight {median:.0f} µs, p99 {late:.0f} µs")


if __name__ == "__main__":
    main()
