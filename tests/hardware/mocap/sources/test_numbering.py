"""Frames without numbers are numbered by when they come."""

from __future__ import annotations

import random

import pytest

from doorman.hardware.mocap.sources.numbering import ArrivalNumbers


def numbers(arrivals, rate=100.0):
    counter = ArrivalNumbers(rate)
    return [counter.number(1000.0 + at) for at in arrivals]


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
