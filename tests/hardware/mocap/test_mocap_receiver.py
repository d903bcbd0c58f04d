"""The receiver over UDP on loopback: poses, times and frames; opening, closing and misuse."""

from __future__ import annotations

import math
import socket
import threading
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from mocap_rig import NAME, free_port, swaying, true_position, true_velocity
from virtual_time import CLOCK

from doorman.clocks import REAL_TIME
from doorman.exceptions import BackendError, DimensionError
from doorman.hardware.mocap import MocapConfig, MocapFault, MocapReceiver, PoseQuality
from doorman.hardware.mocap.connection import parse_connection
from doorman.hardware.mocap.tracker import Pipeline
from doorman.rig.emulators.mocap.emulator import BodyPose, MocapEmulator, TrackedBody, TrackerSetup


def test_poses_are_true_at_the_time_of_their_stamp(rig):
    rows = []
    sample = rig.receiver.read()
    for _ in range(60):
        sample = rig.receiver.wait(sample, 1.0)
        rows.append(sample)
    errors = [np.linalg.norm(one.position - true_position(one.time)) for one in rows]
    assert np.median(errors) < 0.003
    lag = 0.5 * rig.config.velocity_window
    misses = [np.linalg.norm(one.velocity - true_velocity(one.time - lag)) for one in rows]
    assert np.median(misses) < 0.02
    assert np.median([abs(one.attitude[2] - 0.4 * math.sin(0.9 * one.time)) for one in rows]) < 0.01
    assert np.median([one.body_rates[2] - 0.36 * math.cos(0.9 * (one.time - lag)) for one in rows]) == pytest.approx(
        0.0, abs=0.03
    )
    assert all(later.frame_number > former.frame_number for former, later in pairwise(rows))
    assert all(later.count > former.count for former, later in pairwise(rows))
    assert all(one.age > rig.config.latency - 1e-9 for one in rows)


def test_frames_and_offsets(make_rig):
    frames = {
        "origin_position": (1.0, -2.0, 0.5), "origin_attitude": (0.0, 0.0, 2.0),
        "object_position": (0.05, 0.02, 0.08), "object_attitude": (0.1, -0.2, math.pi),
    }  # fmt: skip
    rig = make_rig(emulator=frames, **frames)
    rig.receiver.open()
    sample = rig.until_fresh()
    truth = swaying(sample.time)
    w, x, y, z = truth.quaternion
    assert pin.rpy.rpyToMatrix(sample.attitude) == pytest.approx(pin.Quaternion(w, x, y, z).matrix(), abs=0.01)


def test_frames_are_timed_by_the_clock_that_no_time_server_changes(make_rig, monkeypatch):
    rig, fed = make_rig(), []
    monkeypatch.setattr(Pipeline, "feed", lambda pipeline, *given: fed.append(given[2:]))
    monkeypatch.setattr(CLOCK, "raw", lambda: -1.0)
    with pytest.raises(BackendError, match="no packets arrive"):
        rig.receiver.open(0.3)
    assert fed
    assert all(arrival > 0.0 and raw == -1.0 for arrival, raw in fed)
    before, raw = time.clock_gettime(time.CLOCK_MONOTONIC_RAW), REAL_TIME.raw()
    assert before <= raw <= time.clock_gettime(time.CLOCK_MONOTONIC_RAW)


def test_figures_of_the_stream(rig):
    rig.until(lambda sample: sample.count > 60)
    figures = rig.receiver.statistics
    assert figures.poses <= figures.frames <= figures.packets
    assert figures.frame_rate == pytest.approx(rig.config.rate, rel=0.1)
    assert figures.interval == pytest.approx(rig.config.period, rel=0.3)
    assert 0.0 <= figures.delay <= figures.delay_p99 <= figures.delay_max
    assert figures.latency == pytest.approx(rig.config.latency + figures.delay)
    assert figures.velocity_lag == pytest.approx(0.025, abs=0.005)
    assert figures.jitter >= 0.0
    assert not figures.counts.get(MocapFault.CORRUPT)


def test_many_objects_in_several_packets(make_rig):
    others = {f"other {index}": TrackedBody(lambda at: BodyPose([at, 0.0, 0.0])) for index in range(5)}
    rig = make_rig(emulator={"bodies": others})
    rig.receiver.open()
    rig.until_fresh()
    assert not rig.has(MocapFault.DUPLICATED)
    assert not rig.has(MocapFault.MISSING)


def test_it_listens_on_loopback_only(rig):
    port = parse_connection(rig.config.connection)[1]
    rows = [line.split()[1] for line in Path("/proc/net/udp").read_text().splitlines()[1:]]
    assert [row for row in rows if row.endswith(f":{port:04X}")] == [f"0100007F:{port:04X}"]


def threads() -> set[threading.Thread]:
    return {one for one in threading.enumerate() if one.name == "mocap receiver"}


def test_constructor_touches_no_device():
    port, before = free_port(), threads()
    receiver = MocapReceiver(MocapConfig(NAME, f"udp:{port}"))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", port))
        with pytest.raises(BackendError, match=r"cannot listen: Address already in use.*mocap|mocap\.connection"):
            receiver.open()
    assert threads() == before


def test_with_opens_and_always_stops(make_rig):
    rig, before = make_rig(), threads()
    with pytest.raises(KeyError), rig.receiver:
        assert rig.receiver.read().count > 0
        assert len(threads() - before) == 1
        raise KeyError
    with pytest.raises(BackendError, match="not open"):
        rig.receiver.read()
    assert threads() == before
    rig.receiver.stop()
    with rig.receiver as again:
        assert again.read().count > 0


def test_open_twice_is_refused(rig):
    with pytest.raises(BackendError, match="open already"):
        rig.receiver.open()
    assert rig.receiver.read().count > 0


@pytest.mark.parametrize("call", ["read", "statistics", "wait"])
def test_nothing_works_before_open(call):
    receiver = MocapReceiver(MocapConfig(NAME))
    with pytest.raises(BackendError, match="not open"):
        receiver.wait(None, 1.0) if call == "wait" else getattr(receiver, call) and receiver.read()


def test_wait_gives_up(rig):
    rig.emulator.faults.silent = True
    lost = rig.until_lost()
    with pytest.raises(BackendError, match=r"no new pose.*0\.05 s"):
        rig.receiver.wait(lost, 0.05)


@pytest.mark.parametrize(
    ("faults", "told"),
    [
        ({"silent": True}, "no packets arrive"),
        ({"wrong_name": "wand"}, "the stream holds only: wand"),
        ({"absent": True}, "the stream holds only: no object"),
        ({"frozen": True}, "the cameras do not see the object"),
        ({"truncate": 1.0}, "only damaged packets arrive"),
        ({"outliers": 1.0}, "no steady poses arrive"),
    ],
)
def test_open_tells_why_there_is_no_pose(make_rig, faults, told):
    rig = make_rig(emulator={"packet_size": None}, faults=faults)
    with pytest.raises(BackendError) as refusal:
        rig.receiver.open(0.25)
    assert told in str(refusal.value)


def test_a_sender_can_be_prescribed(make_rig):
    rig = make_rig(sender="127.0.0.2")
    with pytest.raises(BackendError, match="only packets from other senders arrive"):
        rig.receiver.open(0.3)


def test_open_refuses_another_rate(make_rig):
    rig = make_rig(emulator={"rate": 150.0})
    with pytest.raises(
        BackendError,
        match=r"mocap\.rate: the cameras send frames at another rate \(given 100\.0; allowed: the stream's 1",
    ):
        rig.receiver.open()


def test_a_vehicle_that_does_not_move_is_not_occluded(make_rig):
    rig = make_rig(source=lambda at: BodyPose([1.0, 2.0, 3.0]))
    rig.receiver.open()
    sample = rig.until(lambda sample: sample.count > 30)
    assert sample.quality is PoseQuality.MEASURED or not rig.has(MocapFault.OCCLUDED)
    assert sample.position == pytest.approx([1.0, 2.0, 3.0], abs=1e-3)
    assert np.linalg.norm(sample.velocity) < 0.05


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("udp:51001", ("127.0.0.1", 51001)),
        ("udp:0.0.0.0:51001", ("0.0.0.0", 51001)),
        ("udp://10.1.2.3:7", ("10.1.2.3", 7)),
        (" udp:localhost:9 ", ("localhost", 9)),
    ],
)
def test_addresses(text, address):
    assert parse_connection(text) == address


@pytest.mark.parametrize(
    "text", ["", "udp:", "udp:0", "udp:65536", "tcp:1.2.3.4:5", "51001", "udp:a b:1", "udp:1:2:3", "udp:٣"]
)
def test_malformed_addresses(text):
    with pytest.raises(BackendError, match=r"mocap\.connection.*loopback unless a host is written"):
        MocapConfig(NAME, text)


@pytest.mark.parametrize(
    ("fields", "named"),
    [
        ({"object_name": ""}, "object_name"),
        ({"object_name": "x" * 25}, "object_name"),
        ({"object_name": "a\0b"}, "object_name"),
        ({"sender": "vicon"}, "sender"),
        ({"rate": 0.0}, "rate"),
        ({"rate": math.nan}, "rate"),
        ({"rate": 5000.0}, "rate"),
        ({"latency": -0.1}, "latency"),
        ({"stale_after": 0.012}, "stale_after"),
        ({"prediction_limit": 0.02}, "prediction_limit"),
        ({"velocity_window": 0.01}, "velocity_window"),
        ({"silent_after": 0.005}, "silent_after"),
        ({"max_speed": -1.0}, "max_speed"),
        ({"max_acceleration": math.inf}, "max_acceleration"),
        ({"acquire_frames": 1}, "acquire_frames"),
        ({"missing_frames": 0}, "missing_frames"),
        ({"open_timeout": 0.0}, "open_timeout"),
    ],
)
def test_settings_are_checked(fields, named):
    with pytest.raises(BackendError, match=rf"mocap\.{named}: out of range \(given"):
        MocapConfig(**{"object_name": NAME} | fields)


@pytest.mark.parametrize("name", ["origin_position", "origin_attitude", "object_position", "object_attitude"])
def test_offsets_are_checked(name):
    with pytest.raises(DimensionError, match=rf"mocap\.{name}"):
        MocapConfig(NAME, **{name: (0.0, math.nan, 0.0)})


def test_address_of_another_computer_is_refused():
    with pytest.raises(BackendError, match="cannot listen"):
        MocapReceiver(MocapConfig(NAME, f"udp:192.0.2.1:{free_port()}")).open()


def test_emulator_sends_what_tracker_sends():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as channel:
        channel.bind(("127.0.0.1", 0))
        channel.settimeout(30.0)
        setup = TrackerSetup("quad", first_frame=41, position_noise=0.0, attitude_noise=0.0)
        with MocapEmulator(lambda at: BodyPose([1.0, 2.0, 3.0]), setup, channel.getsockname()) as emulator:
            first, second = channel.recv(2048), channel.recv(2048)
        assert len(first) == 256
        assert first[:8] == bytes.fromhex("2900000001004800")
        assert first[8:32] == b"quad".ljust(24, b"\0")
        assert np.frombuffer(first[32:80], "<f8") == pytest.approx([1000.0, 2000.0, 3000.0, 0.0, 0.0, 0.0])
        assert second[0] == 42
        assert emulator.sent >= 2


@pytest.mark.parametrize("fields", [{"rate": 0.0}, {"rate": 2001.0}, {"latency": math.nan}])
def test_settings_of_the_emulator_are_checked(fields):
    with pytest.raises(BackendError, match=next(iter(fields))):
        TrackerSetup("quad", **fields)
