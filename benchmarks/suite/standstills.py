"""What the machine itself does to a loop: one that has nothing to do, at the same rate, priority and core.

What such a loop misses, no planner or controller could have kept: other guests of the host and the kernel took the time.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from typing import Any

import numpy as np

from doorman.hardware.scheduling import real_time
from doorman.hardware.vehicle.ticker import Ticker


def measure(rate: float, seconds: float, core: int | None = None) -> dict[str, Any]:
    """Ticks of a loop that does nothing, in a process of its own.

    Args:
        rate: Of the ticks [Hz].
        seconds: For so long.
        core: Where it runs; anywhere if not given.

    Returns:
        Ticks, ticks that were left out since one came more than a period late, and how far the periods were off [s].
    """
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_loop, args=(rate, seconds, core, sender))
    process.start()
    try:
        if not receiver.poll(seconds + 60.0):
            raise TimeoutError("the loop that does nothing did not end")
        found: dict[str, Any] = receiver.recv()
    finally:
        process.join(timeout=5.0)
        if process.is_alive():
            process.kill()
    return found


def _loop(rate: float, seconds: float, core: int | None, sender: Any) -> None:
    if core is not None:
        os.sched_setaffinity(0, {core})
    ticker = Ticker(1.0 / rate)
    with real_time() as priority:
        end = time.monotonic() + seconds
        while ticker.wait() < end:
            pass
    off = np.abs(np.array(ticker.periods) - ticker.period)
    levels = {"median": 50.0, "p99": 99.0, "p99.9": 99.9, "max": 100.0}
    sender.send({
        "ticks": len(ticker.periods) + 1, "missed": ticker.missed, "priority": priority,
        "off": {name: float(np.percentile(off, level)) for name, level in levels.items()},
    })  # fmt: skip
