"""Parts of the adapter alone, with time made up: stream, authority, rates, poses, events, answers, watchdog."""

from __future__ import annotations

import math
import threading
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk import (
    AttitudeSetpoint,
    Authority,
    Battery,
    EventKind,
    LocalFrame,
    PixhawkConfig,
    PositionSetpoint,
    ThrustCurve,
    VehicleSample,
)
from doorman.hardware.pixhawk.authority import AuthorityKeeper
from doorman.hardware.pixhawk.dialect import ARDUPILOT, PX4
from doorman.hardware.pixhawk.events import CONDITIONS, EventLog
from doorman.hardware.pixhawk.exchange import Exchange, StatusText
from doorman.hardware.pixhawk.link import _Timer
from doorman.hardware.pixhawk.mocap import MocapOutlet, MocapPose
from doorman.hardware.pixhawk.modes import ardupilot_mode, px4_mode, px4_number
from doorman.hardware.pixhawk.origin import Origin
from doorman.hardware.pixhawk.rates import RateKeeper
from doorman.hardware.pixhawk.setpoints import FULL_POSITION, POSITION_AND_YAW
from doorman.hardware.pixhawk.stream import SetpointStream, Source, here
from doorman.hardware.pixhawk.timesync import ClockMap
from doorman.hardware.pixhawk.watchdog import Watchdog

CONFIG = PixhawkConfig("udp:14540", thrust_curve=ThrustCurve(0.4, 30.0))
TARGET = (1, 1)
OFFBOARD, LAND, MANUAL = PX4.companion_mode, PX4.land_mode, px4_mode(px4_number(3))
NO = np.zeros(3)


def sample(**changes) -> VehicleSample:
    values = {"position": np.array([1.0, 2.0, 3.0]), "attitude": np.array([0.1, 0.0, 0.5]), "velocity": NO,
              "attitude_time": 10.0, "position_time": 10.0, "heartbeat_time": 10.0}  # fmt: skip
    return VehicleSample(**{**values, **changes})


# ---------------------------------------------------------------- stream


@pytest.fixture
def events():
    return EventLog()


@pytest.fixture
def stream(events):
    return SetpointStream(CONFIG, events)


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


@given(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), st.floats(5.0, 60.0))
def test_thrust_along_the_body_survives_the_division_by_the_tilt(roll, pitch, force):
    stream = SetpointStream(CONFIG, EventLog())
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
    first = stream.message(10.3, sample(position_time=10.29), TARGET)
    moved = sample(position=np.array([9.0, 9.0, 9.0]), position_time=10.4)
    second = stream.message(10.4, moved, TARGET)
    assert (first.x, first.z) == (second.x, second.z) == (1.0, -3.0), "one place, not wherever it drifts"
    assert events.conditions == {EventKind.SETPOINT_STALE}
    stream.offer(AttitudeSetpoint(30.0, NO), 10.5)
    assert stream.message(10.5, sample(), TARGET).get_type() == "SET_ATTITUDE_TARGET"
    assert events.conditions == frozenset()


def test_a_silent_controller_without_a_place_to_hold_ends_the_stream(stream):
    stream.hold(PositionSetpoint(NO, 0.0))
    stream.offer(AttitudeSetpoint(30.0, NO), 10.0)
    assert stream.message(12.0, sample(position_time=10.0), TARGET) is None


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


# ---------------------------------------------------------------- authority


@pytest.fixture
def keeper(stream, events):
    return AuthorityKeeper(stream, events)


def beat(keeper, mode, armed=True, status=4, now=10.0, dialect=PX4):
    keeper.heartbeat(mode, armed, status, dialect, now)


def engaged(keeper, stream):
    stream.hold(PositionSetpoint(NO, 0.0))
    keeper.prepare()
    beat(keeper, OFFBOARD)
    assert keeper.state is Authority.ENGAGED


def test_the_heartbeat_alone_engages(keeper, stream):
    keeper.prepare()
    beat(keeper, MANUAL)
    assert keeper.state is Authority.PREPARING
    beat(keeper, OFFBOARD)
    assert keeper.state is Authority.ENGAGED


def test_another_mode_ends_all_commanding_until_it_is_asked_for_again(keeper, stream, events):
    engaged(keeper, stream)
    beat(keeper, MANUAL)
    assert keeper.state is Authority.LOST and stream.source is Source.OFF
    beat(keeper, OFFBOARD)
    assert keeper.state is Authority.LOST, "the pilot's switch back is no permission"
    assert EventKind.CONTROL_LOST in events.conditions
    assert not keeper.request_landing(None)
    keeper.prepare()
    beat(keeper, OFFBOARD)
    assert EventKind.CONTROL_LOST not in events.conditions


@pytest.mark.parametrize(("dialect", "mode"), [(PX4, LAND), (ARDUPILOT, ardupilot_mode(9))])
def test_landing_is_asked_for_until_it_is_seen(keeper, stream, dialect, mode):
    stream.hold(PositionSetpoint(NO, 0.0))
    keeper.prepare()
    beat(keeper, dialect.companion_mode, dialect=dialect)
    assert keeper.request_landing(None)
    asked = [keeper.requests(10.0 + 0.1 * k, dialect, TARGET) for k in range(10)]
    commands = [message.command for messages in asked for message in messages]
    assert commands == [mavlink.MAV_CMD_DO_SET_MODE, mavlink.MAV_CMD_NAV_LAND, mavlink.MAV_CMD_DO_SET_MODE]
    assert stream.source is Source.HOLD, "until then it is held, so that no failsafe acts"
    beat(keeper, mode, dialect=dialect)
    assert keeper.state is Authority.LANDING and stream.source is Source.OFF
    assert keeper.requests(20.0, dialect, TARGET) == []
    assert keeper.request_landing(None)
    beat(keeper, mode, armed=False, dialect=dialect)
    assert keeper.state is Authority.NONE


def test_the_controller_is_kept_out_of_a_landing(keeper, stream):
    engaged(keeper, stream)
    assert keeper.hold(PositionSetpoint(NO, 0.0), latch=False)
    assert stream.offer(PositionSetpoint(NO, 0.0), 10.0)
    assert keeper.request_landing(PositionSetpoint(NO, 0.0))
    assert stream.source is Source.HOLD and not stream.offer(PositionSetpoint(NO, 0.0), 10.0)
    beat(keeper, MANUAL)
    assert not keeper.hold(PositionSetpoint(NO, 0.0), latch=False)
    assert stream.source is Source.OFF


def test_the_pilot_may_interrupt_a_landing(keeper, stream):
    engaged(keeper, stream)
    keeper.request_landing(None)
    beat(keeper, LAND)
    beat(keeper, MANUAL)
    assert keeper.state is Authority.LOST and not keeper.landing_requested
    engaged(keeper, stream)
    keeper.request_landing(None)
    beat(keeper, MANUAL)
    assert keeper.state is Authority.LOST and keeper.requests(99.0, PX4, TARGET) == []


def test_a_landed_vehicle_that_disarms_and_goes_back_to_its_mode_is_not_lost(keeper, stream, events):
    engaged(keeper, stream)
    keeper.request_landing(None)
    beat(keeper, LAND)
    beat(keeper, OFFBOARD, armed=False)
    assert keeper.state is Authority.NONE
    assert EventKind.CONTROL_LOST not in events.conditions


def test_disarming_that_nobody_asked_for_is_a_loss_of_control(keeper, stream, events):
    engaged(keeper, stream)
    beat(keeper, OFFBOARD, armed=False)
    assert keeper.state is Authority.LOST
    engaged(keeper, stream)
    keeper.expect_disarm()
    beat(keeper, OFFBOARD, armed=True)
    beat(keeper, OFFBOARD, armed=False)
    assert keeper.state is Authority.NONE


def test_a_critical_state_is_a_failsafe(keeper, events):
    for status, expected in ((4, False), (5, True), (6, True), (3, False)):
        beat(keeper, MANUAL, status=status)
        assert (EventKind.AUTOPILOT_FAILSAFE in events.conditions) is expected


def test_changes_of_mode_and_arming_are_noted_once(keeper, events):
    for mode, armed in ((MANUAL, False), (MANUAL, True), (LAND, True), (LAND, True), (LAND, False)):
        beat(keeper, mode, armed=armed)
    kinds = [event.kind for event in events.drain()]
    assert kinds == [EventKind.ARMED, EventKind.MODE_CHANGED, EventKind.DISARMED]


# ---------------------------------------------------------------- rates and timers


def test_streams_are_asked_for_until_they_run():
    keeper = RateKeeper({31: 100.0, 147: 1.0})
    assert {message.param1 for message in keeper.requests(10.0, *TARGET)} == {31.0, 147.0}
    assert keeper.requests(10.5, *TARGET) == []
    for _ in range(100):
        keeper.heard(31)
    (again,) = keeper.requests(11.0, *TARGET)
    assert (again.command, again.param1, again.param2) == (mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 147.0, 1e6)
    assert keeper.measured[31] == pytest.approx(100.0)
    keeper.heard(12345)


def test_an_autopilot_that_cannot_is_asked_ever_more_rarely_and_in_the_older_way():
    keeper = RateKeeper({31: 100.0})
    asked = [(10.0 + k, keeper.requests(10.0 + k, *TARGET)) for k in range(60)]
    times = [now for now, messages in asked if messages]
    assert len(times) < 12 and times[-1] - times[-2] >= 8.0
    kinds = {message.get_type() for _, messages in asked for message in messages}
    assert kinds == {"COMMAND_LONG", "REQUEST_DATA_STREAM"}
    keeper.restart()
    assert keeper.requests(70.0, *TARGET), "after a reboot, at once"


def test_a_rate_that_the_autopilot_refuses_is_asked_for_by_half():
    keeper = RateKeeper({31: 200.0})
    asked = [message for k in range(12) for message in keeper.requests(10.0 + k, *TARGET)]
    intervals = [message.param2 for message in asked if message.get_type() == "COMMAND_LONG"]
    assert intervals[:2] == [5000.0, 5000.0], "a request may get lost"
    assert intervals[2:] == [10000.0, *[20000.0] * (len(intervals) - 3)], "and no less than a quarter"
    assert keeper.asked[31] == 50.0


def test_a_rate_that_was_granted_is_kept_through_a_silence():
    keeper = RateKeeper({31: 200.0})
    now = 10.0
    while keeper.asked[31] > 100.0:
        keeper.requests(now := now + 1.0, *TARGET)
    asked = []
    for _ in range(20):
        for _ in range(100):
            keeper.heard(31)
        asked += keeper.requests(now := now + 1.0, *TARGET)
    assert [message.param2 for message in asked] == [5000.0] * 2, "it may have been silent for another reason"
    assert keeper.asked[31] == 100.0, "but it was refused"
    asked = [message for k in range(1, 11) for message in keeper.requests(now + k, *TARGET)]
    assert {message.param2 for message in asked if message.get_type() == "COMMAND_LONG"} == {10000.0}
    keeper.restart()
    assert keeper.asked[31] == 200.0


def test_a_stream_that_begins_late_runs_at_its_whole_rate():
    keeper, now, rate = RateKeeper({32: 100.0}), 10.0, 0.0
    for k in range(40):
        for message in keeper.requests(now + k, *TARGET):
            if message.get_type() == "COMMAND_LONG":
                rate = 1e6 / message.param2
        for _ in range(round(rate) if k > 12 else 0):  # without a position there is none to send
            keeper.heard(32)
    assert keeper.asked[32] == 100.0 and keeper.measured[32] == pytest.approx(100.0)


# ---------------------------------------------------------------- origin


def test_the_origin_is_given_until_it_is_heard_and_poses_follow_later():
    origin = Origin((47.4, 8.5, 488.0))
    assert not origin.settled(0.0, armed=False) and origin.settled(0.0, armed=True)
    given, asked = origin.messages(5.0, *TARGET)
    assert (given.latitude, given.longitude, given.altitude) == (474000000, 85000000, 488000)
    assert (asked.command, asked.param1) == (mavlink.MAV_CMD_REQUEST_MESSAGE, 49.0)
    assert origin.messages(5.5, *TARGET) == [] and len(origin.messages(6.1, *TARGET)) == 2
    origin.heard(6.2)
    assert origin.messages(7.5, *TARGET) == []
    assert not origin.settled(8.1, armed=False) and origin.settled(8.3, armed=False)
    origin.reset()
    assert not origin.settled(8.4, armed=False) and origin.messages(8.5, *TARGET), "after a reboot, anew"


def test_poses_are_sent_to_an_autopilot_that_tells_no_origin_too():
    origin = Origin((47.4, 8.5, 488.0))
    origin.messages(5.0, *TARGET)
    assert not origin.settled(24.9, armed=False) and origin.settled(25.1, armed=False)
    origin.heard(25.2)
    assert not origin.settled(27.1, armed=False) and origin.settled(27.3, armed=False)


def test_a_timer_keeps_its_rate_and_does_not_make_up_for_what_it_missed():
    timer = _Timer(0.01)
    ticks = sum(timer.due(5.0 + 0.0007 * k) for k in range(1430))
    assert ticks == pytest.approx(100, abs=3)
    assert timer.due(9.0)
    assert sum(timer.due(9.0 + 0.001 * k) for k in range(1, 5)) == 0


# ---------------------------------------------------------------- poses


def pose(time: float) -> MocapPose:
    return MocapPose.checked(time, [1.0, 2.0, 3.0], [math.cos(0.1), 0.0, 0.0, math.sin(0.1)])


def test_a_pose_goes_out_once_with_the_time_of_its_capture():
    outlet = MocapOutlet(LocalFrame(), 50.0, 0.5)
    assert outlet.message(10.0) is None
    assert outlet.offer(pose(9.98), 10.0)
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
        outlet.offer(pose(now - 0.001), now)
        sent += outlet.message(now) is not None
    assert sent == pytest.approx(50, abs=2)
    outlet.offer(pose(10.999), 11.0)
    assert outlet.message(12.0) is None, "half a second later it is no pose any more"
    assert outlet.statistics().dropped == 1
    assert not outlet.offer(pose(11.0), 13.0)


# ---------------------------------------------------------------- events, answers, watchdog


def test_conditions_begin_and_end_once(events):
    assert events.condition(EventKind.LINK_LOST, True, 1.0, "silence", silent=0.7)
    assert not events.condition(EventKind.LINK_LOST, True, 2.0, "silence")
    assert events.condition(EventKind.LINK_LOST, False, 3.0, "silence")
    begin, end = events.drain()
    assert begin.begins and begin.values["silent"] == 0.7 and not end.begins
    assert events.drain() == () and events.conditions == frozenset()
    assert EventKind.LINK_LOST in CONDITIONS and EventKind.REBOOTED not in CONDITIONS


def test_a_flood_of_events_is_cut_and_the_memory_is_bounded():
    log = EventLog(capacity=10)
    for k in range(100):
        log.happen_at_most(1.0, EventKind.CORRUPTED, 0.1 * k, "noise")
    assert len(log.drain()) == 10
    for k in range(1000):
        log.happen(EventKind.STATUS_TEXT, float(k), "text")
    assert len(log.drain()) == 10


def test_answers_that_are_older_than_the_question_do_not_count():
    exchange = Exchange()
    exchange.post_acknowledgement(400, 0)
    asked = exchange.count
    assert exchange.acknowledgement(400, asked) is None
    assert exchange.wait(lambda: exchange.acknowledgement(400, asked), 0.01) is None
    timer = threading.Timer(0.02, lambda: exchange.post_acknowledgement(400, 4))
    timer.start()
    answer = exchange.wait(lambda: exchange.acknowledgement(400, asked), 5.0)
    timer.join()
    assert answer is not None and answer.result == 4


def test_texts_come_once_each():
    exchange = Exchange()
    for time in (1.0, 2.0, 3.0):
        exchange.post_text(StatusText(time, 2, "PreArm: gyros"))
    assert exchange.texts(1.5) == ["PreArm: gyros"] and exchange.texts(5.0) == []
    exchange.post_text(StatusText(4.0, 6, "EKF3 IMU0 origin set"))
    assert exchange.texts(1.5, 4) == ["PreArm: gyros"]


@pytest.mark.parametrize(
    ("silent", "changes", "expected"),
    [
        (0.1, {}, set()),
        (0.6, {}, {EventKind.LINK_LOST}),
        (0.1, {"heartbeat_time": 6.0}, {EventKind.HEARTBEAT_LOST}),
        (0.1, {"position_time": 9.7}, {EventKind.STATE_STALE}),
        (0.1, {"attitude_time": -math.inf}, {EventKind.STATE_STALE}),
        (0.1, {"battery": Battery(remaining=0.1, time=9.0)}, {EventKind.BATTERY_LOW}),
        (0.1, {"battery": Battery(alarm=True, time=9.0)}, {EventKind.BATTERY_LOW}),
        (0.1, {"battery": Battery(voltage=13.0, time=9.0)}, {EventKind.BATTERY_LOW}),
        (0.1, {"battery": Battery(voltage=15.0, remaining=0.5, time=9.0)}, set()),
        (0.1, {"battery": Battery(time=9.0)}, set()),
    ],
)
def test_the_watchdog_knows_what_is_old_and_what_is_low(events, silent, changes, expected):
    watchdog = Watchdog(replace(CONFIG, min_voltage=14.0), events)
    watchdog.check(10.0, 10.0 - silent, sample(**changes), ClockMap(), None)
    assert events.conditions == expected | {EventKind.CLOCK_UNSYNCHRONISED}


def test_a_battery_at_its_threshold_does_not_flicker(events):
    watchdog = Watchdog(CONFIG, events)
    for remaining in (0.21, 0.199, 0.201, 0.199, 0.202):
        watchdog.check(10.0, 10.0, sample(battery=Battery(remaining=remaining, time=9.0)), ClockMap(), None)
    assert [event.begins for event in events.drain() if event.kind is EventKind.BATTERY_LOW] == [True]


def test_a_pose_that_stays_away_is_noticed(events):
    watchdog = Watchdog(CONFIG, events)
    watchdog.check(10.0, 10.0, sample(), ClockMap(), 9.7)
    assert EventKind.MOCAP_LOST not in events.conditions
    watchdog.check(10.0, 10.0, sample(), ClockMap(), 9.4)
    assert EventKind.MOCAP_LOST in events.conditions


def test_an_attitude_setpoint_without_a_curve_is_refused_before_it_is_taken():
    from doorman.hardware.pixhawk import Autopilot

    with pytest.raises(BackendError, match="newtons"):
        Autopilot(PixhawkConfig("udp:14540")).setpoint(AttitudeSetpoint(1.0, NO))
