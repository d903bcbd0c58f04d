"""Mapping of the autopilot's clock: offset, drift, outliers, jumps, reboots, answers that are not ours."""

from __future__ import annotations

import math
import random

import pytest

from doorman.hardware.pixhawk.link.timesync import ClockMap, SyncResult


class Wire:
    """Two clocks with a line between them; all in seconds."""

    def __init__(self, offset: float = 1000.0, rate: float = 1.0, delay: float = 0.001, seed: int = 1) -> None:
        self.map = ClockMap()
        self.offset, self.rate, self.delay = offset, rate, delay
        self.now = 5000.0
        self.random = random.Random(seed)

    def remote(self, local: float) -> float:
        return (local - 5000.0) * self.rate + self.offset

    def ping(self, there: float | None = None, back: float | None = None, period: float = 0.1) -> SyncResult:
        there = self.delay * self.random.uniform(0.5, 1.5) if there is None else there
        back = self.delay * self.random.uniform(0.5, 1.5) if back is None else back
        ts1 = self.map.ask(round(self.now * 1e9))
        tc1 = round(self.remote(self.now + there) * 1e9)
        result = self.map.answer(ts1, tc1, round((self.now + there + back) * 1e9))
        self.now += period
        return result

    def error(self) -> float:
        """Of a stamp that is mapped now."""
        return abs(self.map.to_local(self.remote(self.now - 0.01), self.now) - (self.now - 0.01))


def pinged(count: int = 20, **settings) -> Wire:
    """After some answers."""
    wire = Wire(**settings)
    for _ in range(count):
        wire.ping()
    return wire


def test_nothing_is_mapped_before_there_are_enough_answers():
    wire = Wire()
    assert not wire.map.synchronised
    assert wire.map.to_local(3.0, 77.0) == 77.0
    assert math.isnan(wire.map.offset(0.0))
    for _ in range(4):
        assert wire.ping() is SyncResult.ACCEPTED
    assert wire.map.synchronised
    assert wire.error() < 0.001


def test_jitter_is_averaged_away():
    wire = pinged(60, delay=0.004)
    assert wire.error() < 0.002
    assert wire.map.round_trip == pytest.approx(0.008, rel=0.3)


@pytest.mark.parametrize("rate", [0.8, 0.999, 1.0001, 1.25])
def test_a_clock_that_runs_at_another_rate_is_followed(rate):
    """A simulated autopilot may run slower than real time."""
    wire = pinged(80, rate=rate)
    assert wire.error() < 0.004


def test_a_slow_answer_is_an_outlier_and_changes_nothing():
    wire = pinged(30)
    before = wire.map.offset(wire.now)
    wire.ping(there=0.2, back=0.001)
    assert abs(wire.map.offset(wire.now) - before) < 0.001
    assert wire.ping(there=0.6, back=0.1) is SyncResult.SLOW


def test_a_single_wild_answer_is_kept_aside():
    wire = pinged()
    wire.offset += 3.0
    assert wire.ping() is SyncResult.OUTLIER
    wire.offset -= 3.0
    wire.now += 5.0
    assert wire.ping() in (SyncResult.ACCEPTED, SyncResult.OUTLIER)
    for _ in range(20):
        wire.ping()
    assert wire.error() < 0.002


@pytest.mark.parametrize(("jump", "result"), [(2.0, SyncResult.JUMPED), (-1001.5, SyncResult.REBOOTED)])
def test_a_jump_forwards_is_followed_and_one_backwards_is_a_reboot(jump, result):
    wire = pinged()
    wire.offset += jump
    results = [wire.ping() for _ in range(8)]
    assert results.count(result) == 1
    assert {SyncResult.JUMPED, SyncResult.REBOOTED} & set(results) == {result}
    assert wire.error() < 0.002


def test_answers_that_overtake_each_other_are_no_reboot():
    clock = ClockMap()
    base = 10**12
    asked = [clock.ask(base + k * 10_000_000) for k in range(40)]
    order = [k ^ 1 for k in range(40)]
    results = [clock.answer(asked[k], asked[k] - base + 10**9, asked[max(k, k ^ 1)] + 11_000_000) for k in order]
    assert SyncResult.REBOOTED not in results


def test_answers_to_others_and_second_copies_are_not_taken():
    wire = Wire()
    assert wire.map.answer(12345, 10**9, 20000) is SyncResult.UNASKED
    ts1 = wire.map.ask(10**9)
    assert wire.map.answer(ts1, 5 * 10**9, 10**9 + 1000) is SyncResult.ACCEPTED
    assert wire.map.answer(ts1, 5 * 10**9, 10**9 + 2000) is SyncResult.UNASKED


def test_a_stamp_is_never_mapped_into_the_future():
    wire = pinged(10)
    assert wire.map.to_local(wire.remote(wire.now + 50.0), wire.now) == wire.now
    assert wire.map.ahead(wire.remote(wire.now + 50.0), wire.now) == pytest.approx(50.0, abs=0.01)


def test_figures_out_of_this_world_do_no_harm():
    clock = ClockMap()
    for value in (-(2**63), 2**63 - 1, 0, -1):
        clock.answer(clock.ask(10**9), value, 10**9 + 500)
    clock.answer(clock.ask(10**9), 10**9, 0)
    assert isinstance(clock.to_local(1.0, 2.0), float)


@pytest.mark.parametrize("rate", [0.5, 1.0, 2.0, 5.0])
def test_no_wrong_map_while_the_first_answers_come_in_quick_succession(rate):
    wire = Wire(rate=rate, delay=0.0005)
    errors = []
    for _ in range(40):
        wire.ping(period=0.02)
        if wire.map.synchronised:
            errors.append(wire.error())
    assert len(errors) > 20 and max(errors) < 0.012


def test_slow_answers_do_not_keep_a_quick_one_from_mapping_the_clock():
    """On a busy computer answers are late on one side, by half their round trip; a quick one is true and must not be alone."""
    clock, offset = ClockMap(), 5.0
    for index, (there, back) in enumerate([(0.0002, 0.0002), (0.0, 0.024), (0.0, 0.026), (0.0, 0.022)]):
        asked = 10.0 + 0.03 * index
        clock.answer(
            clock.ask(round(asked * 1e9)), round((asked + there - offset) * 1e9), round((asked + there + back) * 1e9)
        )
    assert clock.synchronised
    assert abs(clock.offset(10.1) - offset) < 0.014
