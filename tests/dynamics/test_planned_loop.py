"""The attitude loop as plans take it."""

from __future__ import annotations

import pytest

from doorman.dynamics.attitude_loop import AttitudeLoop


@pytest.mark.parametrize(
    ("loop", "lag", "dead_time"),
    [
        (AttitudeLoop(0.047, 0.065), 0.1, 0.065), (AttitudeLoop(0.05, 0.01), 0.1, 0.01),
        (AttitudeLoop(0.2, 0.03), 0.2, 0.03),
    ],
)  # fmt: skip
def test_a_quick_loop_is_planned_with_as_the_usual_one(loop: AttitudeLoop, lag: float, dead_time: float) -> None:
    planned = loop.planned(0.02)
    assert (planned.lag, planned.dead_time) == pytest.approx((lag, dead_time))
    assert loop.lag + loop.shaping == pytest.approx(lag)


def test_a_coarse_step_takes_lag_for_dead_time() -> None:
    planned = AttitudeLoop(0.1, 0.05).planned(0.05)
    assert planned.lag == pytest.approx(0.14) and planned.lag + planned.dead_time == pytest.approx(0.15)
    assert AttitudeLoop(0.1, 0.0).planned(0.1).dead_time == 0.0
