"""A straight way: it begins and ends where it should, at its speed, by the shorter turn."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.hardware.pixhawk.straight_way import SPEED, StraightWay

BEGIN, END = np.array([0.2, -0.4, 1.0]), np.array([-1.0, 0.5, 1.5])


@pytest.mark.parametrize("speed", [SPEED, 0.6])
def test_it_leads_from_one_place_to_the_other_and_rests_there(speed: float) -> None:
    way = StraightWay(5.0, BEGIN, END, 0.3, 0.3, speed)
    length = float(np.linalg.norm(END - BEGIN))
    assert way.duration == pytest.approx(length / speed)
    first, middle, last = (way.setpoint(5.0 + share * way.duration) for share in (0.0, 0.5, 1.5))
    np.testing.assert_allclose(first.position, BEGIN)
    np.testing.assert_allclose(middle.position, 0.5 * (BEGIN + END))
    np.testing.assert_allclose(last.position, END)
    np.testing.assert_allclose(middle.velocity, (END - BEGIN) / length * speed)
    np.testing.assert_allclose(last.velocity, 0.0)
    np.testing.assert_allclose(way.setpoint(4.0).position, BEGIN)


def test_it_turns_the_shorter_way_and_takes_the_time_for_it() -> None:
    way = StraightWay(0.0, BEGIN, BEGIN, math.radians(170.0), math.radians(-170.0))
    assert way.duration == pytest.approx(math.radians(20.0) / 0.5)
    assert way.setpoint(0.5 * way.duration).yaw == pytest.approx(math.pi)


def test_a_vehicle_that_is_there_is_told_to_stay() -> None:
    way = StraightWay(0.0, BEGIN, BEGIN, 0.0, 0.0)
    assert 0.0 < way.duration < 0.1
    np.testing.assert_allclose(way.setpoint(0.5 * way.duration).velocity, 0.0)
