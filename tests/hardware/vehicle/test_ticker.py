"""Ticks by the clock: never early, on a grid, and late ones are left out."""

from __future__ import annotations

import time

import pytest

from doorman.hardware.vehicle.ticker import Ticker


def test_ticks_stand_on_a_grid_and_are_never_early():
    ticker = Ticker(0.005)
    first = ticker.wait()
    for count in range(1, 21):
        tick = ticker.wait()
        assert (tick - first) / 0.005 >= count - 1e-6
    assert ticker.statistics().ticks == 21


def test_missed_ticks_are_counted_and_not_made_up_for():
    ticker = Ticker(0.005)
    ticker.wait()
    time.sleep(0.0525)
    late = ticker.wait()
    after = ticker.wait()
    assert ticker.missed >= 9
    assert after - late > 0.0
    figures = ticker.statistics()
    assert figures.longest >= 0.0525
    assert figures.missed == ticker.missed
    assert figures.ticks == 3


def test_figures_of_even_ticks():
    ticker = Ticker(0.01)
    ticker.periods = [0.01] * 999 + [0.02]
    figures = ticker.statistics()
    assert figures.median == pytest.approx(0.01)
    assert figures.longest == pytest.approx(0.02)
