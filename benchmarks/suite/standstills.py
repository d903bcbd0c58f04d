"""What the machine itself does to a loop: one that has nothing to do, at the same rate, priority and core.

What such a loop misses, no planner or controller could have kept: other guests of the host and the kernel took the time.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Iterator
from typing import Any

import numpy as np

from doorman.hardware.scheduling import real_time
from suite.statistics import quantiles

_SPIN = 2e-4
"""The last part of a wait that is not slept [s]."""


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
    sender.close()
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
    lateness = []
    with real_time() as priority:
        for tick, _ in ticks(seconds, rate):
            lateness.append(time.perf_counter() - tick)
    late, left_out = np.array(lateness), round(seconds * rate) - len(lateness)
    sender.send({
        "ticks": len(late), "missed": int((late > 1.0 / rate).sum()) + left_out, "priority": priority,
        "off": quantiles(np.abs(np.diff(late))),
    })  # fmt: skip


def ticks(length: float, rate: float) -> Iterator[tuple[float, float]]:
    """Wait for every tick of a time; those that are past already are left out.

    Args:
        length: [s].
        rate: [Hz].

    Yields:
        Time of the tick by `time.perf_counter`, and of the next one, which is its deadline [s].
    """
    period, begun = 1.0 / rate, time.perf_counter() + 0.01
    for k in range(round(length * rate)):
        tick = begun + k * period
        now = time.perf_counter()
        if now >= tick + period:
            continue
        if tick - now > _SPIN:
            time.sleep(tick - now - _SPIN)
        while time.perf_counter() < tick:
            pass
        yield tick, tick + period
