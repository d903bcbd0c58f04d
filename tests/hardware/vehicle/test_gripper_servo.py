"""The gripper's servo: it goes to where it is wanted, stays there, and never beyond its limits."""

from __future__ import annotations

import pytest

from doorman.hardware.vehicle.gripper import CLOSED, LOWER, OPEN, RATE, SHUT, UPPER, gripper_rate


@pytest.mark.parametrize(("begin", "closed", "end"), [(OPEN, True, SHUT), (SHUT, False, OPEN), (0.4, True, SHUT)])
def test_it_arrives_and_stays(begin, closed, end):
    angle, step = begin, 0.005
    for _ in range(400):
        rate = gripper_rate(angle, closed)
        assert abs(rate) <= RATE
        angle += step * rate
        assert LOWER < angle < UPPER
    assert angle == pytest.approx(end, abs=0.03)
    assert gripper_rate(angle, closed) == 0.0
    assert (angle > CLOSED) is closed
