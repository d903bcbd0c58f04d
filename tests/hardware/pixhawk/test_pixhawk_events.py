"""Events, answers and texts of the autopilot, and the watchdog over what is old or low."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from pixhawk_parts import CONFIG, sample
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from virtual_time import CLOCK, Aside

from doorman.hardware.pixhawk import Battery, EventKind
from doorman.hardware.pixhawk.events import LinkLog
from doorman.hardware.pixhawk.link.exchange import Exchange, StatusText, TextParts
from doorman.hardware.pixhawk.link.timesync import ClockMap
from doorman.hardware.pixhawk.link.watchdog import Watchdog


def test_conditions_begin_and_end_once(events):
    assert events.condition(EventKind.LINK_LOST, True, 1.0, "silence", silent=0.7)
    assert not events.condition(EventKind.LINK_LOST, True, 2.0, "silence")
    assert events.condition(EventKind.LINK_LOST, False, 3.0, "silence")
    begin, end = events.take()
    assert begin.begins and begin.values["silent"] == 0.7 and not end.begins
    assert events.take() == [] and events.conditions == frozenset()


def test_a_flood_of_events_is_cut_and_the_memory_is_bounded():
    log = LinkLog(size=10)
    for k in range(100):
        log.happen_at_most(1.0, EventKind.CORRUPTED, 0.1 * k, "noise")
    assert len(log.take()) == 10
    for k in range(1000):
        log.happen(EventKind.STATUS_TEXT, float(k), "text")
    assert len(log.take()) == 10


def test_answers_that_are_older_than_the_question_do_not_count():
    exchange = Exchange(CLOCK)
    exchange.post(400, 0)
    asked = exchange.count
    assert exchange.answer(400, asked) is None
    assert exchange.wait(lambda: exchange.answer(400, asked), 0.01) is None
    timer = Aside(lambda: exchange.post(400, 4), after=0.02)
    answer = exchange.wait(lambda: exchange.answer(400, asked), 5.0)
    timer.result()
    assert answer is not None and answer.value == 4


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
    assert [event.begins for event in events.take() if event.kind is EventKind.BATTERY_LOW] == [True]


@pytest.mark.parametrize(("told", "silent", "expected"), [(0.5, 0.1, True), (0.5, 5.0, False), (math.nan, 0.1, False)])
def test_a_charge_that_is_told_no_more_is_noticed_where_the_autopilot_is_heard(events, told, silent, expected):
    watchdog = Watchdog(CONFIG, events)
    watchdog.check(10.0, 10.0, sample(battery=Battery(remaining=told, time=9.9)), ClockMap(), None)
    later = sample(battery=Battery(time=21.0))
    watchdog.check(15.0, 15.0, later, ClockMap(), None)
    assert EventKind.BATTERY_SILENT not in events.conditions
    watchdog.check(21.0, 21.0 - silent, later, ClockMap(), None)
    assert (EventKind.BATTERY_SILENT in events.conditions) is expected
    watchdog.check(21.1, 21.1, sample(battery=Battery(remaining=0.5, time=21.1)), ClockMap(), None)
    assert EventKind.BATTERY_SILENT not in events.conditions


def test_the_charge_of_another_battery_is_not_missed_where_the_first_tells_none(events):
    watchdog = Watchdog(CONFIG, events)
    for now, battery in ((10.0, Battery(remaining=0.8, time=10.0, id=1)), (10.5, Battery(15.0, time=10.5, id=0)),
                         (30.0, Battery(15.0, time=30.0, id=0))):  # fmt: skip
        watchdog.check(now, now, sample(battery=battery), ClockMap(), None)
        assert EventKind.BATTERY_SILENT not in events.conditions


@pytest.mark.parametrize(("pose", "lost"), [(None, False), (9.7, False), (9.4, True)])
def test_a_pose_that_stays_away_is_noticed(events, pose, lost):
    Watchdog(CONFIG, events).check(10.0, 10.0, sample(), ClockMap(), pose)
    assert (EventKind.MOCAP_LOST in events.conditions) is lost


LONG = "Arming denied: the quick brown fox has not calibrated its gyroscopes, and jumps over the lazy dog"
WHOLE = LONG[:50]


def part(text: str, number: int = 0, identifier: int = 3) -> mavlink.MAVLink_statustext_message:
    return mavlink.MAVLink_statustext_message(4, text.encode(), identifier, number)


FIRST, REST = part(WHOLE), part(LONG[50:], 1)
TEXTS = {
    "one part, as PX4 and ArduPilot tell it": ([(0.0, part("Disarmed by landing\t", 0, 0))], ["Disarmed by landing"]),
    "one part of a numbered text": ([(0.0, part("Takeoff detected\t", 0, 7))], ["Takeoff detected"]),
    "what cannot be printed": ([(0.0, part("a\x07b", 0, 0))], ["a?b"]),
    "a long text is one": ([(0.0, FIRST), (0.0, REST)], [LONG]),
    "in whatever order": ([(0.0, REST), (0.0, FIRST)], [LONG]),
    "with copies": ([(0.0, FIRST), (0.0, FIRST), (0.0, REST), (0.1, REST), (2.0, None)], [LONG]),
    "a full last part of ArduPilot": ([(0.0, FIRST), (0.0, part("", 1))], [WHOLE]),
    "a full last part of PX4": ([(0.0, FIRST), (0.4, None), (0.5, None)], [WHOLE]),
    "which may not be the last yet": ([(0.0, FIRST), (0.2, None)], []),
    "the rest is lost": ([(0.0, FIRST), (0.1, part("next", 0, 4))], [WHOLE, "next"]),
    "the beginning is lost": ([(0.0, REST), (1.0, None)], [LONG[50:]]),
    "the rest is late": ([(0.0, FIRST), (0.4, None), (0.5, FIRST), (0.5, REST), (0.9, None)], [WHOLE, LONG[50:]]),
    "the same number again": ([(0.0, FIRST), (0.4, None), (1.5, FIRST), (1.5, REST)], [WHOLE, LONG]),
}
"""Parts with the time at which they come, a look for late ones in between, and the texts that are told of them."""


@pytest.mark.parametrize("name", TEXTS)
def test_texts_that_come_in_parts(name):
    steps, expected = TEXTS[name]
    texts, told = TextParts(), []
    for now, message in steps:
        told += texts.late(10.0 + now) if message is None else texts.take(message, 10.0 + now)
    assert [one.text for one in told] == expected
