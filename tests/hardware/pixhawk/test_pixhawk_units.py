"""Units of MAVLink fields."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from doorman.hardware.pixhawk.wire import messages as units

stamps = st.integers(0, 2**32 - 1)


def test_figures_of_batteries():
    for raw, unit, expected in ((15600, 1e-3, 15.6), (1234, 1e-2, 12.34), (55, 1e-2, 0.55)):
        assert units.figure(raw, unit) == pytest.approx(expected)
    assert all(math.isnan(units.figure(raw, 1.0)) for raw in (-1, 0xFFFF)), "unknown stays unknown"
    assert units.cells_to_volts([3900, 3900, 3800, 0xFFFF]) == 11.6
    assert units.cells_to_volts([0xFFFE, 4466, 0xFFFF]) == 70.0
    assert math.isnan(units.cells_to_volts([0xFFFF] * 10))


@given(stamps, st.integers(-(2**31) + 1, 2**31 - 1))
def test_differences_of_stamps_are_right_across_the_wrap(older, step):
    assert units.boot_ms_difference((older + step) % 2**32, older) == step


@given(st.floats(0.0, 1e7))
def test_stamps_wrap_at_32_bits(seconds):
    stamp = units.seconds_to_boot_ms(seconds)
    assert 0 <= stamp < 2**32
    assert abs(1e-3 * stamp - seconds % (2**32 * 1e-3)) < 1e-3 or stamp == 0
