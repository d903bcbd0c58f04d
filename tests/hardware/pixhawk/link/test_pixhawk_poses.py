"""Poses of motion capture on their way to the autopilot, and the origin that they need first."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pixhawk_parts import TARGET
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.exceptions import DimensionError
from doorman.hardware.pixhawk import LocalFrame
from doorman.hardware.pixhawk.link.mocap import MocapOutlet
from doorman.hardware.pixhawk.link.origin import CautiousOrigin, Origin


def test_the_origin_is_given_until_it_is_heard_and_poses_follow_later():
    origin = Origin((47.4, 8.5, 488.0))
    assert not origin.settled(0.0, armed=False) and origin.settled(0.0, armed=True)
    given, asked = origin.messages(5.0, TARGET, False)
    assert (given.latitude, given.longitude, given.altitude) == (474000000, 85000000, 488000)
    assert (asked.command, asked.param1) == (mavlink.MAV_CMD_REQUEST_MESSAGE, 49.0)
    assert origin.messages(5.5, TARGET, False) == [] and len(origin.messages(6.1, TARGET, False)) == 2
    origin.heard(6.2)
    (asked,) = origin.messages(7.5, TARGET, False)
    assert asked.get_type() == "COMMAND_LONG" and origin.messages(8.6, TARGET, True) == []
    assert not origin.settled(8.1, armed=False) and origin.settled(8.3, armed=False)
    origin.reset()
    assert not origin.settled(8.4, armed=False) and origin.messages(8.5, TARGET, False), "after a reboot, anew"


def test_an_origin_that_is_told_of_no_more_is_given_again_while_the_vehicle_stands():
    origin = Origin((47.4, 8.5, 488.0))
    origin.messages(5.0, TARGET, False)
    origin.heard(5.1)
    for now in np.arange(5.5, 40.0, 0.5):
        origin.messages(now, TARGET, now > 10.0)
        assert origin.known and (now < 7.2 or origin.settled(now, armed=False)), "in flight nobody asks"
    sent = [len(origin.messages(now, TARGET, False)) for now in np.arange(40.1, 47.0, 0.5)]
    assert not origin.known and max(sent[:9]) == 1 and max(sent[9:]) == 2
    assert not origin.settled(47.0, armed=False), "its poses wait for it"
    origin.heard(47.0)
    assert origin.known and origin.settled(49.1, armed=False)


def test_poses_are_sent_to_an_autopilot_that_tells_no_origin_too():
    origin = Origin((47.4, 8.5, 488.0))
    origin.messages(5.0, TARGET, False)
    assert not origin.settled(24.9, armed=False) and origin.settled(25.1, armed=False)
    origin.heard(25.2)
    assert not origin.settled(27.1, armed=False) and origin.settled(27.3, armed=False)


STANDS = mavlink.ESTIMATOR_CONST_POS_MODE
NAVIGATES = mavlink.ESTIMATOR_POS_HORIZ_REL | STANDS
"""A vehicle that stands on the ground is in that mode, too, as PX4 has it."""


def given(origin: CautiousOrigin, now: float, armed: bool = False) -> bool:
    """Whether PX4 would get an origin, of altitude zero, now; it is asked for its own either way."""
    messages = origin.messages(now, TARGET, armed)
    assert [message.param1 for message in messages if message.get_type() == "COMMAND_LONG"] == [49.0, 230.0]
    origins = [message for message in messages if message.get_type() == "SET_GPS_GLOBAL_ORIGIN"]
    assert all(message.altitude == 0 and message.latitude == 474000000 for message in origins)
    return bool(origins)


def asked(
    origin: CautiousOrigin, flags: int | None, armed: bool = False, begin: float = 5.0, times: int = 8
) -> list[bool]:
    """At which of some questions it gets an origin; each is answered with the estimator's flags, if at all."""
    seen = []
    for k in range(times):
        seen.append(given(origin, begin + 0.6 * k, armed))
        if flags is not None:
            origin.estimator(flags)
    return seen


@pytest.mark.parametrize("times", [2, 4])
def test_px4_is_asked_before_it_gets_an_origin_and_one_that_has_it_gets_no_other(times):
    origin = CautiousOrigin((47.4, 8.5, 488.0))
    assert asked(origin, STANDS, times=times) == [False, False, False, True][:times]
    assert not origin.settled(7.0, armed=False)
    origin.heard(7.1)
    assert origin.known and origin.messages(7.7, TARGET, False) == [] and origin.settled(7.2, armed=False)


@pytest.mark.parametrize(("flags", "armed"), [(NAVIGATES, False), (None, False), (STANDS, True)])
def test_px4_that_has_a_position_or_flies_or_does_not_say_gets_no_origin_but_poses(flags, armed):
    origin = CautiousOrigin((47.4, 8.5, 488.0))
    assert not any(asked(origin, flags, armed))
    assert origin.settled(10.1, armed)
    if flags == NAVIGATES:
        assert origin.settled(0.0, armed), "there is nothing to wait for"


def test_px4_gets_no_origin_once_poses_may_have_gone_out():
    origin = CautiousOrigin((47.4, 8.5, 488.0))
    assert not any(asked(origin, None, times=3))
    assert origin.settled(11.0, armed=False), "its patience is over"
    assert not any(asked(origin, STANDS, begin=12.0))


def test_an_old_word_of_its_estimator_is_none():
    origin = CautiousOrigin((47.4, 8.5, 488.0))
    asked(origin, STANDS, times=1)
    assert not any(asked(origin, None, begin=6.0, times=6))


def offer(outlet: MocapOutlet, time: float, now: float) -> bool:
    return outlet.offer(time, [1.0, 2.0, 3.0], [math.cos(0.1), 0.0, 0.0, math.sin(0.1)], now)


def test_a_pose_goes_out_once_with_the_time_of_its_capture():
    outlet = MocapOutlet(LocalFrame(), 50.0, 0.5)
    assert outlet.message(10.0) is None
    assert offer(outlet, 9.98, 10.0)
    message = outlet.message(10.0)
    assert message.get_type() == "VISION_POSITION_ESTIMATE" and message.usec == 9_980_000
    assert [message.x, message.y, message.z, message.yaw] == pytest.approx([1.0, -2.0, -3.0, -0.2])
    assert math.isnan(message.covariance[0])
    assert outlet.message(10.1) is None
    assert outlet.statistics().median_delay == pytest.approx(0.02)


def test_poses_are_thinned_to_their_rate_and_old_ones_are_dropped():
    outlet = MocapOutlet(LocalFrame(), 50.0, 0.5)
    sent = 0
    for k in range(200):
        now = 10.0 + 0.005 * k
        offer(outlet, now - 0.001, now)
        sent += outlet.message(now) is not None
    assert sent == pytest.approx(50, abs=2)
    offer(outlet, 10.999, 11.0)
    assert outlet.message(12.0) is None, "half a second later it is no pose any more"
    assert outlet.statistics().dropped == 1
    assert not offer(outlet, 11.0, 13.0)


@pytest.mark.parametrize(
    ("position", "quaternion", "field"),
    [([math.nan, 0, 0], [1, 0, 0, 0], "position"), ([0, 0], [1, 0, 0, 0], "position"), ([1e9, 0, 0], [1, 0, 0, 0], "mocap"),
     ([0, 0, 0], [2.0, 0, 0, 0], "quaternion")],
)  # fmt: skip
def test_what_is_no_pose_is_refused(position, quaternion, field):
    with pytest.raises(DimensionError, match=field):
        MocapOutlet(LocalFrame(), 50.0, 0.5).offer(10.0, position, quaternion, 10.0)


def test_a_pose_that_is_not_newer_or_from_the_future_is_not_taken():
    outlet = MocapOutlet(LocalFrame(), 50.0, 0.5)
    assert [offer(outlet, time, 10.0) for time in (9.9, 9.9, 9.8, 15.0)] == [True, False, False, False]
