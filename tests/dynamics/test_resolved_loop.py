"""The attitude loop as plans take it."""

from __future__ import annotations

import pytest

from doorman.dynamics.attitude_loop import AttitudeLoop


@pytest.mark.parametrize(
    ("loop", "lag"),
    [(AttitudeLoop(0.047, 0.065), 0.1), (AttitudeLoop(0.05, 0.01), 0.06), (AttitudeLoop(0.2, 0.03), 0.2)],
)
def test_feed_forward_counts_as_dead_time(loop: AttitudeLoop, lag: float) -> None:
    plain = loop.resolved(0.02)
    assert plain.lag == pytest.approx(lag)
    assert plain.lag + plain.dead_time == pytest.approx(loop.lag + loop.dead_time)
    assert plain.stiffness <= AttitudeLoop(0.06).stiffness
