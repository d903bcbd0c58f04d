"""Frames without numbers are numbered by when they come."""

from __future__ import annotations

import random

import pytest

from doorman.hardware.mocap.sources.numbering import BACK, ArrivalNumbers


def numbers(arrivals, rate=100.0, stamped=False):
    counter = ArrivalNumbers(rate)
    return [counter.number(1000.0 + at, stamped) for at in arrivals]


def test_steady_frames_are_counted():
    assert numbers(0.01 * index for index in range(500)) == list(range(500))


def test_jitter_of_a_third_of_a_period_skips_nothing():
    draw = random.Random(3)
    assert numbers(0.01 * index + draw.uniform(0.0, 0.0033) for index in range(2000)) == list(range(2000))


@pytest.mark.parametrize("true_rate", [119.88, 120.1])
def test_a_rate_a_little_off_is_followed(true_rate):
    assert numbers((index / true_rate for index in range(20_000)), 120.0) == list(range(20_000))


def test_frames_that_are_missing_are_counted_as_missing():
    arrivals = [0.01 * index for index in range(100) if index not in (40, 41, 42)]
    assert numbers(arrivals) == [index for index in range(100) if index not in (40, 41, 42)]


def test_a_burst_after_a_gap_has_no_times_and_later_frames_keep_theirs():
    arrivals = [0.01 * index for index in range(50)] + [0.55 + 1e-4 * index for index in range(5)]
    arrivals += [0.01 * index for index in range(56, 80)]
    assert numbers(arrivals) == [*range(50), 55, None, None, None, None, *range(56, 80)]


@pytest.mark.parametrize("stray", [3600.0, 0.7, -0.7, -3600.0])
def test_a_stamp_that_does_not_fit_costs_itself_alone(stray):
    stamps = [0.01 * index for index in range(100)]
    stamps.insert(50, 0.5 + stray)
    counted = numbers(stamps)
    assert counted.pop(50) == pytest.approx(50 + 100 * stray, abs=1)
    assert counted == list(range(100))


def test_the_same_stamp_once_more_is_the_same_frame():
    times = [0.0, 0.01, 0.01, 0.02, 0.021]
    assert numbers(times, stamped=True) == [0, 1, 1, 2, None]
    assert numbers(times) == [0, 1, None, 2, None]


@pytest.mark.parametrize("back", [0.05, 2.0, 3600.0])
def test_a_clock_that_was_set_back_begins_anew_far_away(back):
    counted = numbers([0.01 * index - back * (index >= 50) for index in range(100)])
    anew = counted[50 + BACK - 1 :]
    assert [number - anew[0] for number in anew] == list(range(len(anew)))
    assert anew[0] % 2**32 > max(counted[:50]) + 2**29
