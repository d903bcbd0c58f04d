"""Measure one tick of a bank: 16 states, three hypotheses that hold rows, poses that come in time or late.

Usage: python benchmarks/filter_ticks.py [--ticks 20000]
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import casadi as ca
import numpy as np

from doorman.estimation import Filter, Hypothesis, Measurement, ProcessModel, Row

STATES, TICK, POSES = 16, 0.004, 2
"""Of the vehicle at the leaf: states, time between ticks [s], and ticks from pose to pose."""


def bank() -> Filter:
    """As large and as coupled as a vehicle at a leaf: places, speeds and forces that turn with an angle."""
    x, u = ca.SX.sym("x", STATES), ca.SX.sym("u", 6)
    place, speed, force, angle, rate, load = x[:3], x[3:6], x[6:9], x[9], x[10], x[11:]
    normal = ca.vertcat(ca.cos(angle + u[3]), ca.sin(angle + u[3]), 0)
    pressed = ca.dot(normal, u[:3] + force) - load[0] / ca.exp(load[1])

    def moved(share: float) -> Any:
        push = share * pressed * normal + load[2] * ca.vertcat(-normal[1], normal[0], 0)
        return ca.vertcat(speed, (u[:3] + force - push) / 4, 0, 0, 0, rate, share * pressed - load[0], -load)

    touches = Row("touches", ca.dot(normal, place) - load[3], 0.002, lasts=0.05)
    return Filter(
        ProcessModel(x, u, moved(0.0), [0.0] * 3 + [0.05] * 3 + [0.1] * 10),
        measurements=[Measurement("pose", place, 0.001, gate=8.0)],
        hypotheses=[
            Hypothesis("free"),
            *(Hypothesis(name, dynamics=moved(share), holds=[touches]) for name, share in (("on", 0.5), ("held", 1.0))),
        ],
        switching={(a, b): 1.0 for a in ("free", "on", "held") for b in ("free", "on", "held") if a != b},
    )


def measured(late: int, ticks: int) -> np.ndarray:
    """Time of every tick with its pose, if one came, [µs]."""
    filter, inputs, place, took = bank(), np.zeros(6), np.zeros(3), np.zeros(ticks)
    filter.start(0.0, np.zeros(STATES), np.full(STATES, 0.05))
    for tick in range(1, ticks + 1):
        began = time.perf_counter()
        if tick % POSES == 0 and tick > late:
            filter.measure("pose", (tick - late) * TICK, place)
        filter.step(tick * TICK, inputs)
        took[tick - 1] = 1e6 * (time.perf_counter() - began)
    return took


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--ticks", type=int, default=20_000)
    count = parser.parse_args().ticks
    print("| poses | median [µs] | p99 [µs] |\n| --- | --- | --- |")
    for late in (0, 2, 5):
        took = measured(late, count)[count // 10 :]
        words = "in time" if not late else f"{1e3 * late * TICK:.0f} ms late"
        print(f"| {words} | {np.median(took):.1f} | {np.percentile(took, 99):.1f} |")
