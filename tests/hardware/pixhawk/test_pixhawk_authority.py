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
DESCENT = px4_mode(px4_number(4, 20))


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


def land(keeper):
    assert keeper.request_landing(None)


def expect(keeper):
    keeper.disarm_expected = True


def refused(keeper):
    keeper.disarm_expected = False


KILLED, SHOT = (OFFBOARD, True, 8), (LAND, True, 8)
SCRIPTS = {
    "the pilot's mode": ([MANUAL], Authority.LOST),
    "the pilot's switch back is no permission": ([MANUAL, OFFBOARD], Authority.LOST),
    "it is asked for again": ([MANUAL, AuthorityKeeper.prepare, MANUAL, OFFBOARD], Authority.ENGAGED),
    "it lands": ([land, LAND], Authority.LANDING),
    "PX4 without a height or place lands in a mode of another name": ([land, LAND, DESCENT], Authority.LANDING),
    "it has landed": ([land, LAND, (LAND, False)], Authority.NONE),
    "it has landed, and goes back to its mode": ([land, LAND, (OFFBOARD, False)], Authority.NONE),
    "the pilot interrupts a request to land": ([land, MANUAL], Authority.LOST),
    "the pilot interrupts a landing": ([land, LAND, MANUAL], Authority.LOST),
    "a kill switch": ([KILLED], Authority.LOST),
    "a kill switch that is switched back: it may lie on the floor": ([KILLED, OFFBOARD], Authority.LOST),
    "a kill switch while it lands": ([land, LAND, SHOT], Authority.LOST),
    "a kill switch while the mode is asked for": ([MANUAL, AuthorityKeeper.prepare, KILLED], Authority.LOST),
    "it disarms by itself": ([(OFFBOARD, False)], Authority.LOST),
    "it disarms as we asked": ([expect, (OFFBOARD, False)], Authority.NONE),
    "it disarms after it has refused to": ([expect, refused, (OFFBOARD, False)], Authority.LOST),
    "it disarms before it shows that it lands": ([land, (OFFBOARD, False)], Authority.NONE),
    "it reboots": ([lambda keeper: keeper.rebooted(10.0)], Authority.LOST),
}
"""What happens to a vehicle that is ours, as heartbeats (mode, armed, status) and requests, and whose it is then."""


@pytest.mark.parametrize("name", SCRIPTS)
def test_whose_the_vehicle_is(keeper, stream, events, name):
    steps, state = SCRIPTS[name]
    engaged(keeper, stream)
    for step in steps:
        if callable(step):
            step(keeper)
        else:
            beat(keeper, *(step if isinstance(step, tuple) else (step,)))
    assert keeper.state is state
    assert (EventKind.CONTROL_LOST in events.conditions) is (state is Authority.LOST)
    if state is Authority.ENGAGED:
        return
    assert stream.source is Source.OFF and keeper.requests(99.0, PX4, TARGET) == []
    assert not keeper.if_engaged(lambda one: one.climb(PositionSetpoint(NO, 0.0), 1.0, 10.0))
    assert not keeper.hold(PositionSetpoint(NO, 0.0), latch=False) and stream.source is Source.OFF
    assert keeper.request_landing(None) is (state is Authority.LANDING)


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


@pytest.mark.parametrize(("dialect", "mode"), [(PX4, LAND), (PX4, DESCENT), (ARDUPILOT, ardupilot_mode(9))])
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


def test_a_critical_state_is_a_failsafe(keeper, events):
    for status, expected in ((4, False), (5, True), (6, True), (8, True), (3, False)):
        beat(keeper, MANUAL, status=status)
        assert (EventKind.AUTOPILOT_FAILSAFE in events.conditions) is expected


def test_changes_of_mode_and_arming_are_noted_once(keeper, events):
    for mode, armed in ((MANUAL, False), (MANUAL, True), (LAND, True), (LAND, True), (LAND, False)):
        beat(keeper, mode, armed=armed)
    kinds = [event.kind for event in events.take()]
    assert kinds == [EventKind.ARMED, EventKind.MODE_CHANGED, EventKind.DISARMED]
