"""Faults of docs/hardware/mocap.md: injected on the wire, told, and brought to their end state."""

from __future__ import annotations

import os
import re
import socket

import numpy as np
import pytest
from mocap_rig import is_predicted, true_position
from mocap_table import FAULTS
from virtual_time import CLOCK

from doorman.exceptions import BackendError
from doorman.hardware.mocap import MocapFault, PoseQuality
from doorman.rig.emulators.mocap.emulator import BodyPose, MocapEmulator, TrackerSetup


@pytest.mark.parametrize("row", FAULTS)
def test_fault(rig, row):
    """It is told with words, poses go on or are lost, and all is well when it is over."""
    switch, fault, goes_on, words = FAULTS[row]
    begin, newest = CLOCK.now(), rig.receiver.read()
    for name, value in switch.items():
        setattr(rig.emulator.faults, name, value)
    assert words in rig.until_event(fault).text
    if goes_on:
        for _ in range(10):
            sample = rig.receiver.wait(newest, 1.0)
            assert sample.frame_number > newest.frame_number and MocapFault.OCCLUDED not in sample.fault
            newest = sample
        rig.until_fresh(after=CLOCK.now())
    elif goes_on is False:
        lost = rig.until_lost()
        assert lost.time < begin + 2 * rig.config.period and np.linalg.norm(lost.position) > 0.5
        stale, told = rig.has(MocapFault.STALE), rig.has(MocapFault.LOST)
        assert stale.time <= told.time
    rig.heal()
    rig.until_fresh(after=CLOCK.now())
    rig.until_event(fault, began=False)


def test_short_gap(rig):
    before = rig.until_fresh()
    rig.emulator.faults.silent = True
    sample = rig.until(is_predicted)
    assert not sample.fresh
    assert sample.usable
    assert rig.config.stale_after < sample.age <= rig.config.prediction_limit
    rig.assert_true(before)
    assert np.linalg.norm(sample.position - true_position(sample.time + sample.age)) < 0.03
    rig.emulator.faults.silent = False
    rig.until_fresh(after=sample.time)


def test_jump_that_lasts(rig):
    rig.emulator.faults.jump = (0.0, 3.0, 0.0)
    jumped = CLOCK.now()
    rig.until_event(MocapFault.OUTLIER)
    lost = rig.until_lost()
    assert lost.time < jumped + 2 * rig.config.period, "nothing is believed until the old track is given up"
    event = rig.has(MocapFault.JUMPED)
    assert event is not None and event.time - jumped < (rig.config.acquire_frames + 2) * rig.config.period
    sample = rig.until(lambda sample: sample.fresh and sample.time > jumped)
    assert sample.position - true_position(sample.time) == pytest.approx([0.0, 3.0, 0.0], abs=0.02)


@pytest.mark.parametrize("jump", [(0.03, 0.0, 0.0), (0.0, -0.1, 0.0), (0.1, 0.1, 0.4)])
def test_a_jump_is_told_however_near(rig, jump):
    """The gate opens with time: soon the vehicle could have flown there, but none has."""
    rig.emulator.faults.jump = jump
    jumped = CLOCK.now()
    rig.until_event(MocapFault.JUMPED)
    lost = rig.until_lost()
    assert lost.time < jumped + rig.config.period
    sample = rig.until(lambda sample: sample.fresh)
    assert sample.position - true_position(sample.time) == pytest.approx(jump, abs=0.012)
    assert sample.shift == pytest.approx(jump, abs=0.004)
    rig.heal()
    sample = rig.until(lambda sample: sample.track > lost.track + 1)
    assert sample.shift == pytest.approx((0.0, 0.0, 0.0), abs=0.004)
    rig.until_fresh()


def test_a_jump_that_ends_soon_is_bridged(rig):
    """As when two markers are taken for each other for a moment."""
    before = rig.receiver.read()
    rig.emulator.faults.jump = (0.03, 0.0, 0.0)
    rig.until_event(MocapFault.JUMPED)
    rig.heal()
    end = CLOCK.now() + 0.5
    while CLOCK.now() < end:
        sample = rig.receiver.wait(rig.receiver.read(), 1.0)
        assert sample.usable and sample.shift == before.shift
    rig.until_fresh()


def test_found_again_where_it_may_be(rig):
    rig.emulator.faults.absent = True
    lost = rig.until_lost()
    CLOCK.sleep(0.05)  # counted from pose to pose, and not to when it is looked at, the track is over later
    rig.emulator.faults.absent = False
    rig.until_fresh(after=lost.time)
    assert any("acquired again" in event.text for event in rig.events())
    assert not rig.has(MocapFault.JUMPED)


def test_delay_that_lasts(own_rig):
    own_rig.emulator.faults.delay = 0.25
    own_rig.until_event(MocapFault.DELAYED)
    end = CLOCK.now() + 0.6
    delayed = own_rig.until(lambda sample: sample.quality is PoseQuality.LOST and MocapFault.DELAYED in sample.fault)
    while CLOCK.now() < end:
        delayed = own_rig.receiver.wait(delayed, 1.0)
        assert not delayed.fresh
        assert delayed.age > 0.23, "a delay that lasts is not taken for the new normal"
    own_rig.assert_true(delayed)
    own_rig.emulator.faults.delay = 0.0
    own_rig.until_fresh()


def test_jitter(rig):
    rig.emulator.faults.jitter = 0.03
    for _ in range(30):
        rig.until_fresh(after=rig.receiver.read().time)
    assert rig.receiver.statistics.delay_p99 > 0.01


def test_flipped_bits(rig):
    rig.emulator.faults.corrupt = 0.3
    for _ in range(20):
        sample = rig.until(lambda sample, after=rig.receiver.read().time: sample.fresh and sample.time > after)
        rig.assert_true(sample, 0.1)  # flips in the last bits of a number are not to be told from noise
    rig.emulator.faults.corrupt = 0.0
    rig.until_fresh(after=CLOCK.now())


@pytest.mark.parametrize(("first", "anew"), [(0, 1_000_000), (1_000_000, 7)])
def test_frame_numbers_begin_anew(make_rig, first, anew):
    rig = make_rig(emulator={"first_frame": first})
    rig.receiver.open()
    rig.emulator.stream.frame_number = anew
    event = rig.until_event(MocapFault.RESTARTED)
    assert 0 <= rig.until_fresh(after=event.time).frame_number - anew < 1000
    rig.until_event(MocapFault.NUMBERING, began=False)


def test_frames_left_out_by_tracker(own_rig):
    own_rig.emulator.faults.stride = 3
    own_rig.until_event(MocapFault.DROPPED)
    own_rig.until_event(MocapFault.DROPPED, began=False)
    own_rig.until_fresh(after=CLOCK.now())


@pytest.mark.parametrize("rate", [60.0, 180.0])
def test_rate_that_changes(own_rig, rate):
    own_rig.until_fresh()
    own_rig.emulator.stream.rate = rate
    event = own_rig.until_event(MocapFault.RATE)
    own_rig.until_lost()
    assert event.began
    own_rig.receiver.stop()
    with pytest.raises(BackendError, match="the cameras send frames at another rate") as refusal:
        own_rig.receiver.open()
    told = float(re.search(r"the stream's ([\d.]+) 1/s", str(refusal.value))[1])
    assert told == pytest.approx(rate, rel=0.1)


def test_foreign_sender(rig):
    liar = MocapEmulator(lambda at: BodyPose([9.0, 9.0, 9.0]), rig.config.object_name, rig.emulator.target, CLOCK)
    with liar:
        rig.until_event(MocapFault.FOREIGN)
        for _ in range(10):
            rig.until_fresh(after=rig.receiver.read().time)
    rig.until_event(MocapFault.FOREIGN, began=False)


def test_another_tracker_takes_over(own_rig):
    own_rig.emulator.stop()
    own_rig.until_event(MocapFault.SILENT)
    setup = TrackerSetup(own_rig.config.object_name, first_frame=5_000_000)
    successor = MocapEmulator(own_rig.emulator.stream.source, setup, own_rig.emulator.target, CLOCK)
    with successor:
        event = own_rig.until_event(MocapFault.RESTARTED)
        own_rig.until_fresh(after=event.time)


def test_flood(rig):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as channel:
        fresh = 0
        for _ in range(200):
            for _ in range(20):
                channel.sendto(os.urandom(64), rig.emulator.target)
            fresh += rig.receiver.read().fresh
            CLOCK.sleep(0.001)
    rig.until_event(MocapFault.FOREIGN)
    assert fresh > 0
    rig.until_fresh(after=CLOCK.now())


def test_socket_that_fails(own_rig):
    reading, writing = os.pipe()
    os.dup2(reading, own_rig.receiver._channel.fileno())  # what was a socket is none any more
    os.close(reading)
    os.close(writing)
    own_rig.until_event(MocapFault.SOCKET)
    own_rig.until_event(MocapFault.SOCKET, began=False)
    own_rig.until_fresh(after=CLOCK.now())


def test_adapter_that_fails_in_itself(own_rig, monkeypatch):
    pipeline = own_rig.receiver._pipeline
    feed, failures = pipeline.feed, []

    def failing(*arguments):
        if len(failures) < 5:
            failures.append(arguments)
            raise RuntimeError("on purpose")
        feed(*arguments)

    monkeypatch.setattr(pipeline, "feed", failing)
    assert "on purpose" in own_rig.until_event(MocapFault.INTERNAL).text
    own_rig.until_fresh(after=CLOCK.now())
    own_rig.until_event(MocapFault.INTERNAL, began=False)


def test_thread_that_is_held_up(own_rig, monkeypatch):
    """Packets that wait in the socket keep their age: the last of them is fresh, the others are late."""
    pipeline = own_rig.receiver._pipeline
    tick, held = pipeline.tick, []

    def holding(now):
        if not held:
            held.append(now)
            CLOCK.sleep(0.3)
        tick(now)

    own_rig.until_fresh()
    monkeypatch.setattr(pipeline, "tick", holding)
    own_rig.until(lambda sample: held and not sample.usable)
    own_rig.until_event(MocapFault.DELAYED)
    own_rig.until_fresh(after=held[0])
