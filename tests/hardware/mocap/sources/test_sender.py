"""What `PoseSender` sends is what the receiver's parser and frames make of it."""

from __future__ import annotations

import math
import random
import socket

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from doorman.exceptions import BackendError
from doorman.hardware.mocap import MocapFault, PoseSender
from doorman.hardware.mocap.frames import object_angles, object_quaternion
from doorman.hardware.mocap.packets import ObjectPacket, TrackedObject, pack, parse
from doorman.hardware.mocap.sources.sender import BACK, ArrivalNumbers
from doorman.kinematics.quaternions import angle_between

component = st.floats(-1.0, 1.0)


@given(st.tuples(component, component, component, component).filter(lambda q: np.linalg.norm(q) > 0.1))
def test_angles_of_a_quaternion_turn_the_same(values):
    quaternion = tuple(np.array(values) / np.linalg.norm(values))
    assert (
        angle_between(object_quaternion(object_angles(quaternion)), quaternion) < 5e-6
    )  # least where two axes are nearly one


@pytest.mark.parametrize("pitch", [0.5 * math.pi, -0.5 * math.pi])
@pytest.mark.parametrize("roll", [0.0, 0.7, -2.0])
def test_angles_where_two_axes_are_one(pitch, roll):
    quaternion = object_quaternion((roll, pitch, 0.3))
    assert angle_between(object_quaternion(object_angles(quaternion)), quaternion) < 1e-6


def test_refusals_are_parsed():
    refused = (MocapFault.CORRUPT, MocapFault.FOREIGN, MocapFault.FOREIGN)
    objects = (TrackedObject("body", (1.0, 2.0, 3.0), (0.1, 0.2, 0.3)),)
    assert parse(pack(7, objects, refused)) == ObjectPacket(7, objects, refused)


@pytest.mark.parametrize("item", [b"\xff\x01\x00\x07", b"\xff\x00\x00", b"\xff\x02\x00\x00\x00"])
def test_refusals_that_mean_nothing_are_skipped(item):
    assert parse(b"\x07\0\0\0\x01" + item) == ObjectPacket(7, ())


def test_refusals_beyond_a_datagram_are_left_out(listener):
    with PoseSender(listener.getsockname(), 100.0) as sender:
        assert sender.send({"v": ((1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0))}, 5.0, [MocapFault.FOREIGN] * 400)
    packet = parse(listener.recv(65536))
    assert len(packet.objects) == 1 and len(packet.refused) == 254


@pytest.fixture
def listener():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as channel:
        channel.bind(("127.0.0.1", 0))
        channel.settimeout(1.0)
        yield channel


def test_frames_are_sent_with_numbers_by_their_times(listener):
    with PoseSender(listener.getsockname(), 100.0) as sender:
        sent = [sender.send({"ü" * 20: ((1.0, 2.0, 3.0), (2.0, 0.0, 0.0, 0.0))}, taken=at) for at in (5.0, 5.02, 5.021)]
    assert sent == [True, True, False]
    first, second = (parse(listener.recv(2048)) for _ in range(2))
    assert (second.frame_number - first.frame_number) % 2**32 == 2
    assert first.objects == (TrackedObject("ü" * 12, (1000.0, 2000.0, 3000.0), (0.0, 0.0, 0.0)),)


@pytest.mark.parametrize(
    "pose", [((0.0, math.nan, 0.0), (1.0, 0.0, 0.0, 0.0)), ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))]
)
def test_what_is_no_pose_is_refused(pose, listener):
    with PoseSender(listener.getsockname(), 100.0) as sender, pytest.raises(BackendError, match=r"poses\.vehicle"):
        sender.send({"vehicle": pose})


def test_nobody_listens():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as channel:
        channel.bind(("127.0.0.1", 0))
        target = channel.getsockname()
    with PoseSender(target, 100.0) as sender:
        for index in range(3):
            sender.send({}, taken=0.01 * index)


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
