"""When a run is a success, and the interval of a success rate."""

from __future__ import annotations

import math

import pytest

from doorman.campaign import judge
from doorman.campaign.report.figures import wilson_interval

GOOD = {
    "final_error": 0.4, "unit": "deg", "collisions": 0, "outcome": "completed", "reason": "",
    "contact_fraction": 0.99, "max_push_force_n": 4.0,
}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({}, ""),
        ({"final_error": 1.99}, ""),
        ({"final_error": 2.0}, "+2.0° from the target"),
        ({"final_error": math.nan}, "nan° from the target"),
        ({"final_error": None}, "from the target"),
        ({"final_error": 0.0139, "unit": "m"}, ""),
        ({"final_error": -0.021, "unit": "m"}, "-2.1 cm from the target"),
        ({"collisions": 3}, "3 contacts other than tip and leaf"),
        ({"collisions": 3, "outcome": "touched", "reason": "3 contacts"}, "3 contacts other than tip and leaf"),
        ({"outcome": "given up", "reason": "contact was lost 9 times"}, "given up: contact was lost 9 times"),
        ({"outcome": "cut off", "reason": ""}, "cut off"),
        ({"outcome": None}, "None"),
        ({"outcome": "goal missed", "reason": "it moved"}, "goal missed: it moved"),
        ({"contact_fraction": 0.9}, ""),
        ({"contact_fraction": 0.899}, "the tip was on the leaf for 89.9% of the time, less than 90.0%"),
        ({"contact_fraction": math.nan}, "of the time"),
        ({"max_push_force_n": 15.0}, ""),
        ({"max_push_force_n": 15.01}, "the tip pushed with 15.0 N, more than 15 N"),
        ({"max_push_force_n": math.nan}, "more than 15 N"),
    ],
)
def test_a_success_ended_at_the_target_touched_nothing_and_was_completed(change, words):
    judgement = judge(GOOD | change)
    assert judgement.success is (words == "")
    assert words in judgement.reason and bool(judgement.reason) is bool(words)


@pytest.mark.parametrize(
    ("change", "safe"),
    [
        ({}, True), ({"outcome": "given up"}, True), ({"contact_fraction": 0.5}, True),
        ({"outcome": "goal missed"}, True), ({"final_error": 70.0}, True), ({"collisions": 1}, False),
        ({"outcome": "given up", "collisions": 1}, False), ({"outcome": "failed"}, False), ({"outcome": "cut off"}, False),
    ],
)  # fmt: skip
def test_a_safe_end_is_a_hover_with_nothing_touched(change, safe):
    assert judge(GOOD | change).safe is safe


def test_every_reason_is_told():
    reason = judge(GOOD | {"collisions": 1, "outcome": "cut off", "final_error": 70.0}).reason
    assert reason == "1 contacts other than tip and leaf; cut off; the door ended +70.0° from the target"
    touched = judge(GOOD | {"collisions": 3, "outcome": "touched", "reason": "3 contacts"})
    assert touched.reason == "3 contacts other than tip and leaf", "once"


@pytest.mark.parametrize(("successes", "runs"), [(95, 100), (190, 200), (3, 4), (1, 2), (57, 61)])
def test_the_ends_of_the_interval_are_where_the_score_test_just_rejects(successes, runs):
    for end in wilson_interval(successes, runs):
        score = (successes / runs - end) / math.sqrt(end * (1.0 - end) / runs)
        assert abs(score) == pytest.approx(1.959963984540054, rel=1e-9)


def test_the_interval_of_none_of_all_and_of_nothing():
    assert wilson_interval(0, 20) == (0.0, pytest.approx(1.959964**2 / (20 + 1.959964**2), rel=1e-6))
    assert wilson_interval(20, 20) == (pytest.approx(20 / (20 + 1.959964**2), rel=1e-6), 1.0)
    assert wilson_interval(0, 0) == (0.0, 1.0)
