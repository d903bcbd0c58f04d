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
    exchange.post_acknowledgement(400, 0)
    asked = exchange.count
    assert exchange.acknowledgement(400, asked) is None
    assert exchange.wait(lambda: exchange.acknowledgement(400, asked), 0.01) is None
    timer = Aside(lambda: exchange.post_acknowledgement(400, 4), after=0.02)
    answer = exchange.wait(lambda: exchange.acknowledgement(400, asked), 5.0)
    timer.result()
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


def test_a_pose_that_stays_away_is_noticed(events):
    watchdog = Watchdog(CONFIG, events)
    watchdog.check(10.0, 10.0, sample(), ClockMap(), 9.7)
    assert EventKind.MOCAP_LOST not in events.conditions
    watchdog.check(10.0, 10.0, sample(), ClockMap(), 9.4)
    assert EventKind.MOCAP_LOST in events.conditions


LONG = "Arming denied: the quick brown fox has not calibrated its gyroscopes, and jumps over the lazy dog"


def parts(text: str, identifier: int, *, ends_empty: bool) -> list[mavlink.MAVLink_statustext_message]:
    """What is sent; a whole last part is followed by an empty one where the autopilot is ArduPilot."""
    chunks = [text[k : k + 50] for k in range(0, len(text), 50)]
    if ends_empty and len(chunks[-1]) == 50:
        chunks.append("")
    return [
        mavlink.MAVLink_statustext_message(4, chunk.encode(), identifier, number) for number, chunk in enumerate(chunks)
    ]


def told(messages, texts: TextParts | None = None, now: float = 10.0) -> list[str]:
    texts = texts or TextParts()
    return [one.text for message in messages for one in texts.take(message, now)]


def test_a_text_of_one_part_is_told_at_once():
    assert told(parts("Disarmed by landing\t", 0, ends_empty=False)) == ["Disarmed by landing"]
    assert told(parts("Takeoff detected\t", 7, ends_empty=False)) == ["Takeoff detected"]
    assert told([mavlink.MAVLink_statustext_message(4, b"a\x07b", 0, 0)]) == ["a?b"]


def test_a_long_text_is_one():
    assert told(parts(LONG, 3, ends_empty=False)) == [LONG]
    assert told(reversed(parts(LONG, 3, ends_empty=False))) == [LONG]
    twice = [part for part in parts(LONG, 3, ends_empty=False) for _ in range(2)]
    texts = TextParts()
    assert told(twice, texts) == [LONG]
    assert texts.late(12.0) == []


def test_a_text_whose_last_part_is_full_is_told_by_both():
    text = LONG[:50]
    assert told(parts(text, 3, ends_empty=True)) == [text]
    texts = TextParts()
    assert told(parts(text, 3, ends_empty=False), texts) == []
    assert texts.late(10.2) == []
    assert [(one.text, one.time) for one in texts.late(10.4)] == [(text, 10.4)]
    assert texts.late(10.5) == []


def test_what_came_is_told_where_the_rest_is_lost():
    texts = TextParts()
    assert told(parts(LONG, 3, ends_empty=False)[:1], texts) == []
    assert told(parts("next", 4, ends_empty=False), texts) == [LONG[:50], "next"]
    assert told(parts(LONG, 5, ends_empty=False)[1:], texts) == []
    assert [one.text for one in texts.late(11.0)] == [LONG[50:]]


def test_the_rest_is_told_however_late_it_comes():
    texts, (first, second) = TextParts(), parts(LONG, 3, ends_empty=False)
    assert told([first], texts, 10.0) == []
    assert [one.text for one in texts.late(10.4)] == [LONG[:50]]
    assert told([first, second], texts, 10.5) == []
    assert [one.text for one in texts.late(10.9)] == [LONG[50:]]
