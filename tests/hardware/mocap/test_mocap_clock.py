"""When frames were taken: arrival times made up, stamps against the truth."""

from __future__ import annotations

import random

import pytest

from doorman.hardware.mocap.sequence import (
    FINE,
    FORGIVEN,
    GROSS,
    NEW_RUN,
    FrameClock,
    FrameSequence,
    Order,
    RateMonitor,
)

RATE, LATENCY = 100.0, 0.005


class Wire:
    """Frames that are taken at a rate and arrive after a delay."""

    def __init__(self, rate=RATE, jitter=0.001, drift=0.0):
        self.random = random.Random(1)
        self.clock = FrameClock(RATE, LATENCY)
        self.monitor = RateMonitor(RATE)
        self.rate, self.jitter, self.drift = rate, jitter, drift
        self.frame, self.taken = 100, 5000.0
        self.clock.start(self.frame, self.arrival(0.0))

    def arrival(self, delay):
        return self.taken + LATENCY + delay + self.random.uniform(0.0, self.jitter)

    def run(self, seconds, delay=0.0, ramp=0.0):
        """Errors of the stamps: positive where a pose seems newer than it is."""
        errors, start = [], self.taken
        while self.taken < start + seconds:
            self.frame += 1
            self.taken += (1.0 + self.drift) / self.rate
            arrival = self.arrival(delay + ramp * (self.taken - start))
            self.clock.observe(self.frame, arrival)
            if self.monitor.observe(self.frame, arrival) and self.monitor.learnt is not None:
                self.clock.follow(self.monitor.learnt)
            errors.append(self.clock.time_of(self.frame, arrival) - self.taken)
        return errors


def test_a_first_packet_that_was_late_is_corrected():
    wire = Wire()
    wire.clock.start(wire.frame, wire.taken + LATENCY + 0.015)
    assert max(wire.run(1.0)[5:]) < 0.002


@pytest.mark.parametrize(
    ("before", "drift", "seconds", "oldest"),
    [
        *((0.0, drift, 120.0, 0.008) for drift in (1e-4, -1e-4, 1e-3, -1e-3)),
        *((25.0, drift, 900.0, 0.002) for drift in (1e-4, -1e-4)),
    ],
)
def test_clocks_that_drift_apart_are_followed(before, drift, seconds, oldest):
    """From the start, or as crystals do for a flight."""
    wire = Wire()
    wire.run(before)
    wire.drift = drift
    errors = wire.run(seconds)
    assert max(errors) < 0.002
    assert min(errors) > -oldest


@pytest.mark.parametrize(("ramp", "followed"), [(0.2e-3, 0.012), (0.5e-3, 0.003), (1.0e-3, 0.002), (1.9e-3, 0.002)])
def test_a_queue_that_grows_is_no_rate(ramp, followed):
    wire = Wire()
    wire.run(25.0)
    assert max(wire.run(200.0, ramp=ramp)) < followed
    assert not wire.monitor.wrong


def test_a_rate_is_not_learnt_from_a_busy_computer():
    wire = Wire()
    for _ in range(80):  # twice what a quiet one takes
        wire.run(0.5, delay=wire.random.uniform(0.0, 0.01))
    wire.run(40.0)
    assert wire.monitor.learnt == pytest.approx(0.0, abs=5e-5), "half of what may be made up for as drift"
    errors = wire.run(900.0)
    assert max(errors) < 0.002 and min(errors) > -0.002


@pytest.mark.parametrize("step", [0.002, -0.002])
def test_a_rate_is_not_learnt_from_a_step_in_the_delay(step):
    wire = Wire()
    wire.run(10.0, delay=max(-step, 0.0))
    wire.run(20.0, delay=max(step, 0.0))
    assert wire.monitor.learnt == pytest.approx(0.0, abs=2e-5)


@pytest.mark.parametrize("rate", [50.0, 97.0, 103.0, 120.0, 200.0])
def test_a_wrong_rate_is_told_within_a_second(rate):
    wire = Wire()
    wire.run(3.0)
    wire.rate = rate
    wire.run(1.0)
    assert wire.monitor.wrong
    assert wire.monitor.deviation == pytest.approx(1.0 - rate / RATE if rate > RATE else RATE / rate - 1.0, rel=0.6)


def test_a_short_delay_passes_for_drift_but_slowly():
    wire = Wire(jitter=0.0)
    wire.run(2.0)
    assert max(wire.run(10.0, delay=0.008)) < 0.0015
    assert max(wire.run(300.0, delay=0.008)) < 0.009


def test_a_single_wrong_number_does_not_move_the_clock():
    wire = Wire(jitter=0.0)
    wire.run(1.0)
    wire.clock.observe(wire.frame + 4, wire.taken + 0.01 + LATENCY)  # three frames ahead of its time
    wire.frame, wire.taken = wire.frame + 4, wire.taken + 0.04
    assert min(wire.run(1.0)) > -0.001


@pytest.mark.parametrize("drift", [1.5 * FINE, -1.5 * FINE, 5.0 * FINE])
def test_a_slightly_wrong_rate_is_told_within_ten_seconds(drift):
    wire = Wire()
    wire.run(12.0)
    wire.drift = drift
    wire.run(10.0)
    assert wire.monitor.wrong
    assert abs(wire.monitor.quick) < GROSS


@pytest.mark.parametrize("jitter", [0.001, 0.01])
@pytest.mark.parametrize("delay", [0.02, 0.1, 1.0])
def test_delays_that_set_in_and_end_are_no_wrong_rate(delay, jitter):
    wire = Wire(jitter=jitter)
    wire.run(2.0)
    for _ in range(6):
        for part in (delay, 0.0):
            wire.run(1.3, delay=part)
            assert not wire.monitor.wrong


@pytest.fixture
def sequence():
    return FrameSequence(FrameClock(RATE, LATENCY), RATE)


def classified(sequence, frames, start=0.0):
    return [sequence.classify(number % 2**32, start + number / RATE) for number in frames]


def test_orders_of_frames(sequence):
    assert classified(sequence, [10, 11, 11, 12, 14]) == [Order.NEXT, Order.NEXT, Order.SAME, Order.NEXT, Order.NEXT]
    assert sequence.skipped == 1
    assert sequence.classify(13, 0.145) is Order.LATE
    assert sequence.classify(12, 0.146) is Order.REPEATED


def test_numbers_wrap(sequence):
    start = 2**32 - 3
    assert classified(sequence, range(start, start + 6)) == [Order.NEXT] * 6
    assert sequence.newest == start + 5


def test_every_nth_frame_is_no_loss_once_it_is_usual(sequence):
    classified(sequence, range(0, 200, 4))
    assert sequence.skipped == 0
    sequence.classify(204, 2.04)
    assert sequence.skipped == 1


@pytest.mark.parametrize("offset", [1_000_000, -1_000_000])
def test_a_new_beginning_takes_a_run(sequence, offset):
    start = 2_000_000
    classified(sequence, range(start, start + 10))
    orders = [sequence.classify(start + 10 + k + offset, (start + 10 + k) / RATE) for k in range(NEW_RUN + 1)]
    assert orders == [Order.STRANGE] * (NEW_RUN - 1) + [Order.RESTARTED, Order.NEXT]


def test_a_backlog_makes_no_new_beginning(sequence):
    """Packets that waited for longer than is forgiven and then come all at once."""
    classified(sequence, range(100))
    late = 1.0 + FORGIVEN + 3.0
    orders = [sequence.classify(100 + k, late + 1e-4 * k) for k in range(500)]
    assert Order.RESTARTED not in orders
    assert orders[-1] is Order.NEXT


def test_a_stream_that_is_seconds_behind_begins_anew(sequence):
    classified(sequence, range(1000))
    orders = [sequence.classify(k, 10.0 + k / RATE) for k in range(700)]
    assert Order.RESTARTED in orders
