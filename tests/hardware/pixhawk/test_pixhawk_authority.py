"""Authority: who commands, by the heartbeat alone."""

from __future__ import annotations

import math

import pytest
from pixhawk_parts import TARGET
from pixhawk_rig import NO
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.hardware.pixhawk import Authority, EventKind, PositionSetpoint
from doorman.hardware.pixhawk.authority import AuthorityKeeper
from doorman.hardware.pixhawk.dialect import ARDUPILOT, PX4, ardupilot_mode, px4_mode, px4_number
from doorman.hardware.pixhawk.link.stream import Source

OFFBOARD, LAND, MANUAL = PX4.companion_mode, PX4.land_mode, px4_mode(px4_number(3))


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


def test_nobody_climbs_or_holds_whose_command_is_lost(keeper, stream):
    place = PositionSetpoint(NO, 0.0)
    engaged(keeper, stream)
    assert keeper.climb(place, 1.0, 10.0) and stream.source is Source.CLIMB
    beat(keeper, MANUAL)
    assert not keeper.climb(place, 1.0, 10.1)
    assert not keeper.hold(place, latch=False)
    assert stream.source is Source.OFF


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


def test_landing_is_not_asked_for_again_before_a_heartbeat_can_show_it(keeper, stream):
    """A pilot who chooses another mode meanwhile has chosen it."""
    engaged(keeper, stream)
    keeper.accepted(mavlink.MAV_CMD_DO_SET_MODE, 9.9)
    assert keeper.request_landing(None) and keeper.requests(10.0, PX4, TARGET)
    keeper.accepted(mavlink.MAV_CMD_DO_SET_MODE, 10.1)
    assert not keeper.requests(11.4, PX4, TARGET)
    assert keeper.requests(11.7, PX4, TARGET), "accepted, and not done"
    keeper.accepted(mavlink.MAV_CMD_DO_SET_MODE, 11.8)
    beat(keeper, MANUAL, now=12.0)
    assert keeper.state is Authority.LOST
    assert not keeper.requests(14.0, PX4, TARGET)


@pytest.mark.parametrize(
    ("dialect", "mode"), [(PX4, LAND), (PX4, px4_mode(px4_number(4, 20))), (ARDUPILOT, ardupilot_mode(9))]
)
def test_landing_is_asked_for_until_it_is_seen(keeper, stream, dialect, mode):
    stream.hold(PositionSetpoint(NO, 0.0))
    keeper.prepare()
    beat(keeper, dialect.companion_mode, dialect=dialect)
    assert keeper.request_landing(None)
    asked = []
    for k in range(10):
        asked.append(keeper.requests(10.0 + 0.1 * k, dialect, TARGET))
        assert keeper.request_landing(None), "asked again meanwhile, it goes on as it is"
    commands = [message.command for messages in asked for message in messages]
    assert commands == [mavlink.MAV_CMD_DO_SET_MODE, mavlink.MAV_CMD_NAV_LAND, mavlink.MAV_CMD_DO_SET_MODE]
    places = [
        message.param5 for messages in asked for message in messages if message.command == mavlink.MAV_CMD_NAV_LAND
    ]
    assert [math.isnan(place) for place in places] == [dialect is PX4], "ArduPilot before 4.5 makes an integer of it"
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


def test_a_landing_may_become_a_descent(keeper, stream):
    """PX4 without a height or place lands in a mode of another name."""
    engaged(keeper, stream)
    keeper.request_landing(None)
    beat(keeper, LAND)
    beat(keeper, px4_mode(px4_number(4, 20)))
    assert keeper.state is Authority.LANDING


@pytest.mark.parametrize("asked", [False, True])
def test_a_kill_switch_ends_all_commanding(keeper, stream, events, asked):
    """PX4 is armed, and in the mode that it had, for 5 s more."""
    engaged(keeper, stream)
    if asked:
        keeper.request_landing(None)
        beat(keeper, LAND)
    beat(keeper, LAND if asked else OFFBOARD, status=8)
    assert keeper.state is Authority.LOST and stream.source is Source.OFF
    assert events.conditions >= {EventKind.CONTROL_LOST, EventKind.AUTOPILOT_FAILSAFE}
    beat(keeper, OFFBOARD)
    assert keeper.state is Authority.LOST, "switched back, it may lie on the floor"
    keeper.prepare()
    beat(keeper, OFFBOARD, status=8)
    assert keeper.state is Authority.LOST


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
    keeper.expect_disarm(True)
    beat(keeper, OFFBOARD, armed=True)
    beat(keeper, OFFBOARD, armed=False)
    assert keeper.state is Authority.NONE
    engaged(keeper, stream)
    beat(keeper, OFFBOARD, armed=True)
    keeper.expect_disarm(True)
    keeper.expect_disarm(False)  # it was refused
    beat(keeper, OFFBOARD, armed=False)
    assert keeper.state is Authority.LOST


def test_a_critical_state_is_a_failsafe(keeper, events):
    for status, expected in ((4, False), (5, True), (6, True), (8, True), (3, False)):
        beat(keeper, MANUAL, status=status)
        assert (EventKind.AUTOPILOT_FAILSAFE in events.conditions) is expected


def test_changes_of_mode_and_arming_are_noted_once(keeper, events):
    for mode, armed in ((MANUAL, False), (MANUAL, True), (LAND, True), (LAND, True), (LAND, False)):
        beat(keeper, mode, armed=armed)
    kinds = [event.kind for event in events.take()]
    assert kinds == [EventKind.ARMED, EventKind.MODE_CHANGED, EventKind.DISARMED]
