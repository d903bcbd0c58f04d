"""Motion in free flight: rates of the arm on its way to a posture."""

from __future__ import annotations

import numpy as np

from doorman.control.motion import arm_rates_to


def test_an_arm_moves_on_the_straight_line_and_a_stick_not_at_all() -> None:
    rates = arm_rates_to(np.array([2.0, -1.0]), np.zeros(2))
    np.testing.assert_allclose(rates[0], -2.0 * rates[1])
    assert rates[0] > 0.0 and np.abs(arm_rates_to(np.array([9.0, 0.0]), np.zeros(2))).max() == rates[0]
    assert arm_rates_to(np.zeros(0), np.zeros(0)).shape == (0,)
