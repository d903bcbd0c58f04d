"""A landing told from a fall."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import repeat

import pytest

from doorman.flight.ends import FALLING, FallWatch

PERIOD = 0.02
FALL = [9.81 * PERIOD * k for k in range(25)]
"""From 1.2 m, half a second."""


def watched(speeds: Iterable[float], armed: Iterable[bool], heard: Iterable[bool] = repeat(True)) -> FallWatch:
    watch = FallWatch()
    for k, (speed, runs, hears) in enumerate(zip(speeds, armed, heard, strict=False)):
        watch.note(k * PERIOD, speed, runs, hears)
    return watch


def after_flight(seconds: float, speed: list[float], told_after: float, silent: bool = False) -> FallWatch:
    """Hover, then these speeds, then rest; motors are told to have stopped so long after the hover [s]."""
    hover = round(seconds / PERIOD)
    speeds = [0.05] * hover + speed + [0.0] * round(8.0 / PERIOD)
    times = [PERIOD * (k - hover) for k in range(len(speeds))]
    heard = [not silent or at < 0.0 or at >= told_after for at in times]
    return watched(speeds, [at < told_after for at in times], heard)


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
    assert not watched([5.0] * 50, repeat(True)).fell
    assert not watched([math.nan] * 50, [True] * 10 + [False] * 40).fell
    assert not FallWatch().fell
