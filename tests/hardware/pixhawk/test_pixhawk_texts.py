"""STATUSTEXTs in parts, as either autopilot sends them, and as a lossy line delivers them."""

from __future__ import annotations

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.hardware.pixhawk.wire.texts import TextParts

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
