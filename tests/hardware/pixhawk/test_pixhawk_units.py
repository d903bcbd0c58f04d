"""Units of MAVLink fields."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from doorman.hardware.pixhawk.wire import messages as units

stamps = st.integers(0, 2**32 - 1)


def test_unknown_stays_unknown():
    assert math.isnan(units.millivolts_to_volts(0xFFFF))
    assert math.isnan(units.cells_to_volts([0xFFFF] * 10))
    assert math.isnan(units.centiamperes_to_amperes(-1))
    assert math.isnan(units.percent_to_share(-1))


def test_known_figures():
    assert units.millivolts_to_volts(15600) == 15.6
    assert units.cells_to_volts([3900, 3900, 3800, 0xFFFF]) == 11.6
    assert units.cells_to_volts([0xFFFE, 4466, 0xFFFF]) == 70.0
    assert units.centiamperes_to_amperes(1234) == 12.34
    assert units.percent_to_share(55) == 0.55
    assert units.interval_us(200.0) == 5000
    assert units.seconds_to_us(1.5) == 1_500_000


@given(stamps, st.integers(-(2**31) + 1, 2**31 - 1))
def test_differences_of_stamps_are_right_across_the_wrap(older, step):
    assert units.boot_ms_difference((older + step) % 2**32, older) == step


@given(st.floats(0.0, 1e7))
def test_stamps_wrap_at_32_bits(seconds):
    stamp = units.seconds_to_boot_ms(seconds)
    assert 0 <= stamp < 2**32
    assert abs(units.ms_to_seconds(stamp) - seconds % (2**32 * 1e-3)) < 1e-3 or stamp == 0
