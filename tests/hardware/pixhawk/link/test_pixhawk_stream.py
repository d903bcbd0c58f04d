"""Stream of setpoints: messages in NED, holds, climbs, and what a silent controller is replaced by."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pixhawk_parts import CONFIG, TARGET, sample
from pixhawk_rig import NO

from doorman.hardware.pixhawk import AttitudeSetpoint, Battery, EventKind, PositionSetpoint, ThrustCurve, VehicleSample
from doorman.hardware.pixhawk.events import LinkLog
from doorman.hardware.pixhawk.link.stream import SetpointStream, here
from doorman.hardware.pixhawk.setpoints import FULL_POSITION, POSITION_AND_YAW, SPEED, StraightWay


def test_a_stream_that_is_off_says_nothing_and_takes_nothing(stream):
    assert stream.message(10.0, sample(), TARGET) is None
    assert not stream.offer(PositionSetpoint(NO, 0.0), 10.0)


def test_setpoints_become_messages_in_ned(stream):
    stream.hold(PositionSetpoint(NO, 0.0))
    position = PositionSetpoint(np.array([1.0, 2.0, 3.0]), 0.5, np.array([0.1, 0.2, 0.3]), np.array([4.0, 5.0, 6.0]))
    assert stream.offer(position, 10.0)
    message = stream.message(10.01, sample(), TARGET)
    assert message.get_type() == "SET_POSITION_TARGET_LOCAL_NED" and message.type_mask == FULL_POSITION == 2048
    assert (message.coordinate_frame, message.target_system, message.target_component) == (1, 1, 1)
    assert [message.x, message.y, message.z, message.yaw] == pytest.approx([1.0, -2.0, -3.0, -0.5])
    assert [message.vx, message.vy, message.vz] == pytest.approx([0.1, -0.2, -0.3])
    assert [message.afx, message.afy, message.afz] == pytest.approx([4.0, -5.0, -6.0])
    assert stream.offer(AttitudeSetpoint(30.0, np.array([0.0, 0.0, 0.2])), 10.02)
    message = stream.message(10.03, sample(), TARGET)
    assert message.get_type() == "SET_ATTITUDE_TARGET" and message.type_mask == 7
    assert message.q == pytest.approx([math.cos(0.1), 0.0, 0.0, -math.sin(0.1)])
    assert message.thrust == pytest.approx(0.4)


def test_a_hold_is_position_and_yaw_only(stream):
    stream.hold(here(sample()))
    message = stream.message(10.0, sample(), TARGET)
    assert message.type_mask == POSITION_AND_YAW == 2552
    assert [message.x, message.y, message.z, message.yaw] == pytest.approx([1.0, -2.0, -3.0, -0.5])


def test_a_silent_controller_without_a_place_to_hold_leaves_a_level_vehicle(stream):
    stream.hold(PositionSetpoint(NO, 0.0))
    assert stream.offer(AttitudeSetpoint(33.0, np.array([0.1, 0.2, 0.3])), 10.0)
    assert stream.message(10.0, sample(), TARGET).thrust == pytest.approx(0.44)
    old = sample(position_time=8.0)
    for now in (10.3, 10.5):
        message = stream.message(now, old, TARGET)
        assert message.thrust == pytest.approx(0.4)
        assert message.q == pytest.approx([math.cos(0.15), 0.0, 0.0, -math.sin(0.15)])
    assert stream.message(10.6, old, TARGET) is None


def test_a_hold_after_attitude_setpoints_begins_level(stream):
    """ArduPilot's position control would begin with the tilt that it finds as its integral."""
    stream.hold(here(sample()))
    assert stream.message(9.9, sample(), TARGET).get_type() == "SET_POSITION_TARGET_LOCAL_NED"
    assert stream.offer(AttitudeSetpoint(33.0, np.array([0.1, 0.2, 0.3])), 10.0)
    assert stream.message(10.0, sample(), TARGET).thrust == pytest.approx(0.44)
    stream.hold(PositionSetpoint(NO, 0.7))
    for now in (10.01, 10.2):
        message = stream.message(now, sample(), TARGET)
        assert message.get_type() == "SET_ATTITUDE_TARGET" and message.thrust == pytest.approx(0.4)
        assert message.q == pytest.approx([math.cos(0.35), 0.0, 0.0, -math.sin(0.35)])
        stream.hold(PositionSetpoint(NO, 0.7), latch=True)  # does not begin anew
    for now in (10.27, 10.3, 11.0):
        assert stream.message(now, sample(), TARGET).get_type() == "SET_POSITION_TARGET_LOCAL_NED"


def test_a_hold_brakes_at_once_where_the_tilt_is_not_kept(stream):
    stream.keeps_tilt = False
    stream.hold(here(sample()))
    assert stream.offer(AttitudeSetpoint(33.0, np.array([0.1, 0.2, 0.3])), 10.0)
    assert stream.message(10.0, sample(), TARGET).get_type() == "SET_ATTITUDE_TARGET"
    stream.hold(PositionSetpoint(NO, 0.7))
    assert stream.message(10.01, sample(), TARGET).get_type() == "SET_POSITION_TARGET_LOCAL_NED"
    assert stream.offer(AttitudeSetpoint(33.0, np.array([0.1, 0.2, 0.3])), 10.1)
    assert stream.message(10.1, sample(), TARGET).get_type() == "SET_ATTITUDE_TARGET"
    nowhere = stream.message(10.5, sample(position_time=8.0), TARGET)
    assert nowhere.get_type() == "SET_ATTITUDE_TARGET" and nowhere.q[1] == 0.0, "nowhere to hold: level"


@given(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), st.floats(5.0, 60.0))
def test_thrust_along_the_body_survives_the_division_by_the_tilt(roll, pitch, force):
    stream = SetpointStream(CONFIG, LinkLog())
    stream.angle_boost = True
    stream.hold(PositionSetpoint(NO, 0.0))
    stream.offer(AttitudeSetpoint(force, np.array([roll, pitch, 0.3])), 10.0)
    thrust = stream.message(10.0, sample(), TARGET).thrust
    assert thrust / (math.cos(roll) * math.cos(pitch)) == pytest.approx(0.4 * force / 30.0, rel=1e-5)


def test_the_battery_counts_where_the_curve_says_so(events):
    stream = SetpointStream(replace(CONFIG, thrust_curve=ThrustCurve(0.4, 30.0, hover_voltage=16.0)), events)
    stream.hold(PositionSetpoint(NO, 0.0))
    stream.offer(AttitudeSetpoint(30.0, NO), 10.0)
    weak = sample(battery=Battery(voltage=14.0))
    assert stream.message(10.0, weak, TARGET).thrust > 1.25 * 0.4


def test_a_silent_controller_is_replaced_by_a_hold_where_the_vehicle_is(stream, events):
    stream.hold(PositionSetpoint(NO, 0.0))
    stream.offer(AttitudeSetpoint(30.0, NO), 10.0)
    assert stream.message(10.1, sample(), TARGET).get_type() == "SET_ATTITUDE_TARGET"
    assert stream.message(10.3, sample(position_time=10.29), TARGET).get_type() == "SET_ATTITUDE_TARGET", "level first"
    moved = [sample(position=np.full(3, at), position_time=at) for at in (10.6, 10.7)]
    first, second = (stream.message(one.position_time, one, TARGET) for one in moved)
    assert (first.x, first.z) == (second.x, second.z) == (1.0, -3.0), "one place, not wherever it drifts"
    assert events.conditions == {EventKind.SETPOINT_STALE}
    stream.offer(AttitudeSetpoint(30.0, NO), 10.8)
    assert stream.message(10.8, sample(), TARGET).get_type() == "SET_ATTITUDE_TARGET"
    assert events.conditions == frozenset()


def test_a_climb_rises_at_its_rate_and_ends_at_its_height(stream):
    stream.climb(PositionSetpoint(np.array([1.0, 0.0, 0.2]), 0.3), 1.0, 10.0)
    heights = [-stream.message(10.0 + t, sample(), TARGET).z for t in (0.0, 1.0, 5.0)]
    assert heights == pytest.approx([0.2, 0.7, 1.2])
    assert not stream.offer(PositionSetpoint(NO, 0.0), 10.0), "the controller waits until the climb is over"


def test_gaps_of_the_stream_are_measured(stream):
    stream.hold(PositionSetpoint(NO, 0.0))
    for now in (10.0, 10.01, 10.05, 10.06):
        stream.message(now, sample(), TARGET)
    assert stream.longest_gap == pytest.approx(0.04)


def test_there_is_no_place_to_hold_while_none_is_known():
    assert here(VehicleSample()) is None


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
    middle = way.setpoint(0.5 * way.duration)
    assert middle.yaw == pytest.approx(math.pi) and not middle.velocity.any()
    assert 0.0 < StraightWay(0.0, BEGIN, BEGIN, 0.0, 0.0).duration < 0.1
