"""A puck on a table, seen by a radar: free, or on a rail. In CasADi for the filter, and in numpy for its plain twin."""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np

from doorman.estimation import Filter, Hypothesis, Measurement, Output, ProcessModel, Row

RADAR = np.array([-2.0, -1.0])
MEASURED, SPEED = np.array([0.004, 0.002]), 0.05
GATE = 5.0
RATES = {("free", "rail"): 0.6, ("rail", "free"): 1.1}
RAIL, RAIL_LASTS, FORWARD = 0.02, 0.05, 0.1
NUMBERS = [0.4, 1.0, 0.0]
"""Drag [1/m], scale of the noise, and what poisons the rail's dynamics."""
NOISE = np.array([0.0, 0.0, 0.2, 0.3, 0.05])
RAIL_NOISE = np.array([0.0, 0.0, 0.2, 0.05, 0.05])


@cache
def puck_filter() -> Filter:
    """Compiled once for all tests: each starts it anew."""
    x, u, p = ca.SX.sym("x", 5), ca.SX.sym("u", 2), ca.SX.sym("p", 3)
    speed = ca.sqrt(x[2] ** 2 + x[3] ** 2 + 1e-4)
    free = ca.vertcat(x[2], x[3], u[0] - p[0] * speed * x[2] + x[4], u[1] - p[0] * speed * x[3], -0.5 * x[4])
    rail = ca.vertcat(x[2], x[3], u[0] + x[4] + p[2], 2 * x[2] ** 2 - 20 * x[3], -0.5 * x[4])
    away = x[:2] - ca.DM(RADAR)
    radar = ca.vertcat(ca.sqrt(ca.dot(away, away)), ca.atan2(away[1], away[0]))
    hypotheses = [
        Hypothesis("free"),
        Hypothesis(
            "rail", dynamics=rail, noise=p[1] * ca.DM(RAIL_NOISE),
            holds=[Row("rail", x[3] - 0.1 * x[2] ** 2, RAIL, lasts=RAIL_LASTS)],
            limits=[Row("forward", x[2], FORWARD, lasts=RAIL_LASTS)],
        ),
    ]  # fmt: skip
    return Filter(
        ProcessModel(x, u, free, p[1] * ca.DM(NOISE), parameters=p, lower=[-np.inf] * 4 + [-3.0]),
        measurements=[
            Measurement("radar", radar, MEASURED, gate=GATE),
            Measurement("speed", speed, SPEED, under={"rail": 1.1 * speed}),
        ],
        hypotheses=hypotheses, switching=RATES,
        outputs=[Output("side_force", x[3] * x[4], under={"rail": 2 * x[4]})],
        allowed={"table": ["free"], "rail": ["rail"], "anywhere": ["free", "rail"]},
        parameters=NUMBERS, ticks=32,
    )  # fmt: skip


def rate(name: str, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """ẋ under a hypothesis, in plain numpy."""
    speed = np.sqrt(x[2] ** 2 + x[3] ** 2 + 1e-4)
    if name == "free":
        side = u[1] - NUMBERS[0] * speed * x[3]
        return np.array([x[2], x[3], u[0] - NUMBERS[0] * speed * x[2] + x[4], side, -0.5 * x[4]])
    return np.array([x[2], x[3], u[0] + x[4], 2 * x[2] ** 2 - 20 * x[3], -0.5 * x[4]])


def radar(x: np.ndarray) -> np.ndarray:
    away = x[:2] - RADAR
    return np.array([np.hypot(*away), np.arctan2(away[1], away[0])])


def speed(x: np.ndarray) -> np.ndarray:
    return np.array([np.sqrt(x[2] ** 2 + x[3] ** 2 + 1e-4)])


START = np.array([0.5, 0.05, 1.0, 0.1, 0.0])
DEVIATIONS = np.array([0.05, 0.05, 0.1, 0.1, 0.1])
