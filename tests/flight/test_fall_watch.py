"""A landing told from a fall."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.flight.ends import FALLING, FallWatch

PERIOD = 0.02
GRAVITY = 9.81


FALL = [GRAVITY * PERIOD * k for k in range(25)]
"""From 1.2 m, half a second."""


def watched(speed: np.ndarray, armed: np.ndarray, heard: np.ndarray | None = None) -> FallWatch:
    watch = FallWatch()
    hears = np.ones(speed.size, bool) if heard is None else heard
    for k, (one, runs, hear) in enumerate(zip(speed, armed, hears, strict=True)):
        watch.note(k * PERIOD, float(one), bool(runs), bool(hear))
    return watch


def after_flight(seconds: float, speed: list[float], told_after: float, silent: bool = False) -> FallWatch:
    """Hover, then these speeds, then rest; motors are told to have stopped so long after the hover [s]."""
    hover = np.full(round(seconds / PERIOD), 0.05)
    rest = np.zeros(round(8.0 / PERIOD))
    speeds = np.concatenate([hover, speed, rest])
    times = PERIOD * (np.arange(speeds.size) - hover.size)
    heard = (times < 0.0) | (times >= told_after) if silent else np.ones(times.size, bool)
    return watched(speeds, times < told_after, heard)


@pytest.mark.parametrize("told_after", [0.02, 0.5, 1.2])
def test_motors_that_stop_aloft_are_a_fall_whenever_that_is_told(told_after: float) -> None:
    assert after_flight(3.0, FALL, told_after).fell


def test_an_autopilot_that_restarts_tells_of_it_much_later() -> None:
    assert after_flight(3.0, FALL, 6.0, silent=True).fell
    assert not after_flight(3.0, FALL, 6.0).fell, "heard and armed long after the blow: it flew on"


@pytest.mark.parametrize("told_after", [2.1, 3.0])
def test_a_descent_is_a_landing(told_after: float) -> None:
    assert not after_flight(3.0, [0.7] * 100, told_after).fell


def test_a_blow_long_before_the_landing_is_no_fall() -> None:
    assert not after_flight(1.0, [1.5 * FALLING] * 10 + [0.5] * 150, 3.5).fell


def test_nobody_has_fallen_who_is_armed_or_whose_speed_is_unknown() -> None:
    fast = np.full(50, 5.0)
    assert not watched(fast, np.ones(50, bool)).fell
    assert not watched(np.full(50, math.nan), np.arange(50) < 10).fell
    assert not FallWatch().fell
