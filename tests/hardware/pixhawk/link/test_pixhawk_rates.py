"""Rates of the streams that are asked for, and the timer of our own."""

from __future__ import annotations

import pytest
from pixhawk_parts import TARGET
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.hardware.pixhawk.link.link import _Timer
from doorman.hardware.pixhawk.link.rates import RateKeeper

ATTITUDE, BATTERY = "ATTITUDE_QUATERNION", "BATTERY_STATUS"


def test_streams_are_asked_for_until_they_run():
    keeper = RateKeeper({ATTITUDE: 100.0, BATTERY: 1.0})
    assert {message.param1 for message in keeper.requests(10.0, TARGET)} == {31.0, 147.0}
    assert keeper.requests(10.5, TARGET) == []
    for _ in range(100):
        keeper.heard(ATTITUDE)
    (again,) = keeper.requests(11.0, TARGET)
    assert (again.command, again.param1, again.param2) == (mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 147.0, 1e6)
    assert keeper.rates[ATTITUDE].measured == pytest.approx(100.0)
    keeper.heard("PING")


def test_an_autopilot_that_cannot_is_asked_ever_more_rarely():
    keeper = RateKeeper({ATTITUDE: 100.0})
    asked = [(10.0 + k, keeper.requests(10.0 + k, TARGET)) for k in range(60)]
    times = [now for now, messages in asked if messages]
    assert len(times) < 12 and times[-1] - times[-2] >= 8.0
    keeper.restart()
    assert keeper.requests(70.0, TARGET), "after a reboot, at once"


def test_a_rate_that_the_autopilot_refuses_is_asked_for_by_half():
    keeper = RateKeeper({ATTITUDE: 200.0})
    asked = [message for k in range(12) for message in keeper.requests(10.0 + k, TARGET)]
    intervals = [message.param2 for message in asked]
    assert intervals[:2] == [5000.0, 5000.0], "a request may get lost"
    assert intervals[2:] == [10000.0, *[20000.0] * (len(intervals) - 3)], "and no less than a quarter"
    assert keeper.rates[ATTITUDE].asked == 50.0


def test_a_rate_that_was_granted_is_kept_through_a_silence():
    keeper = RateKeeper({ATTITUDE: 200.0})
    now = 10.0
    while keeper.rates[ATTITUDE].asked > 100.0:
        keeper.requests(now := now + 1.0, TARGET)
    asked = []
    for _ in range(20):
        for _ in range(100):
            keeper.heard(ATTITUDE)
        asked += keeper.requests(now := now + 1.0, TARGET)
    assert [message.param2 for message in asked] == [5000.0] * 2, "it may have been silent for another reason"
    assert keeper.rates[ATTITUDE].asked == 100.0, "but it was refused"
    asked = [message for k in range(1, 11) for message in keeper.requests(now + k, TARGET)]
    assert {message.param2 for message in asked} == {10000.0}
    keeper.restart()
    assert keeper.rates[ATTITUDE].asked == 200.0


def test_a_stream_that_begins_late_runs_at_its_whole_rate():
    keeper, now, rate = RateKeeper({ATTITUDE: 100.0}), 10.0, 0.0
    for k in range(40):
        for message in keeper.requests(now + k, TARGET):
            rate = 1e6 / message.param2
        for _ in range(round(rate) if k > 12 else 0):  # without a position there is none to send
            keeper.heard(ATTITUDE)
    assert keeper.rates[ATTITUDE].asked == 100.0 and keeper.rates[ATTITUDE].measured == pytest.approx(100.0)


def test_a_timer_keeps_its_rate_and_does_not_make_up_for_what_it_missed():
    timer = _Timer(0.01)
    ticks = sum(timer.due(5.0 + 0.0007 * k) for k in range(1430))
    assert ticks == pytest.approx(100, abs=3)
    assert timer.due(9.0)
    assert sum(timer.due(9.0 + 0.001 * k) for k in range(1, 5)) == 0
