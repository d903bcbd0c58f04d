"""Other cameras than Tracker's, through the wheel `motioncapture`: an emulated OptiTrack Motive on loopback."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np
import pytest
from mocap_rig import free_port, swaying, true_position
from natnet import NatNetBody, NatNetEmulator

from doorman.exceptions import BackendError
from doorman.hardware.mocap import MocapConfig, MocapFault, MocapReceiver, PoseQuality, PoseSender, PoseSource
from doorman.hardware.mocap.connection import CamerasLink, ClientProcess, parse_cameras, parse_connection
from doorman.hardware.mocap.receiver import RESTART
from doorman.hardware.mocap.sources import client
from doorman.rig.emulators.mocap.emulator import BodyPose

PATIENT = {"stale_after": 0.06, "prediction_limit": 0.2, "max_delay": 0.05, "latency": 0.0}
"""For loaded machines."""


def seen(at: float) -> BodyPose:
    """A swaying vehicle with the noise of cameras."""
    noise = 1e-5 * np.sin(1e6 * at + np.arange(3))
    return BodyPose(np.add(true_position(at), noise), swaying(at).quaternion)


class Motive:
    """An emulator with a receiver of its body."""

    def __init__(self, version: tuple[int, int]) -> None:
        self.body = NatNetBody("vehicle", 7, seen)
        other = NatNetBody("wand", 2, lambda at: BodyPose((5.0 + at % 1.0, 0.0, 0.0)))
        port = free_port()
        self.emulator = NatNetEmulator([other, self.body], port, free_port(), version=version)
        self.receiver = MocapReceiver(MocapConfig("vehicle", f"optitrack:127.0.0.1:{port}", **PATIENT))
        self.events: list[str] = []

    def until(self, condition, timeout=5.0):
        """Wait until a sample meets a condition."""
        end = time.monotonic() + timeout
        while not condition(sample := self.receiver.read()):
            self.events += map(str, self.receiver.events())
            assert time.monotonic() < end, f"{sample} {self.events}"
            time.sleep(0.002)
        return sample


@pytest.fixture(scope="module", params=[(3, 1), (4, 1)], ids=["NatNet 3.1", "NatNet 4.1"])
def motive(request) -> Iterator[Motive]:
    made = Motive(request.param)
    with made.emulator, made.receiver:
        yield made


def test_poses_are_those_of_their_times(motive):
    motive.until(lambda sample: sample.fresh)
    sample = motive.receiver.read()
    for _ in range(20):
        sample = motive.receiver.wait(sample, 1.0)
        assert np.linalg.norm(sample.position - true_position(sample.time)) < 0.012
        turned = 2.0 * np.arccos(abs(np.dot(sample.quaternion, swaying(sample.time).quaternion)))
        assert turned < 0.02


def test_a_body_that_is_not_seen_is_missing_then_lost_then_found(motive):
    motive.body.tracked = False
    motive.until(lambda sample: MocapFault.MISSING in sample.fault and sample.quality is PoseQuality.LOST)
    motive.body.tracked = True
    motive.until(lambda sample: sample.fresh)


def test_cameras_that_fall_silent_are_told(motive):
    motive.emulator.silent = True
    motive.until(lambda sample: MocapFault.SILENT in sample.fault and sample.quality is PoseQuality.LOST)
    motive.emulator.silent = False
    motive.until(lambda sample: sample.fresh)


def test_a_client_that_dies_is_started_again(motive):
    motive.until(lambda sample: sample.fresh)
    died = motive.receiver._client._process
    died.kill()
    motive.until(lambda sample: MocapFault.CLIENT in sample.fault)
    motive.until(lambda sample: sample.fresh, RESTART + 5.0)
    assert motive.receiver._client._process.pid != died.pid
    motive.until(lambda sample: MocapFault.CLIENT not in sample.fault, RESTART + 2.0)


def test_a_receiver_that_stops_ends_its_client():
    receiver = MocapReceiver(MocapConfig("vehicle", f"optitrack:127.0.0.1:{free_port()}", **PATIENT))
    with pytest.raises(BackendError, match="no packets arrive"):
        receiver.open(timeout=0.5)
    receiver.stop()


def test_what_the_client_said_last_is_in_the_error():
    receiver = MocapReceiver(MocapConfig("vehicle", "optitrack:127.0.0.1,port_command=many", **PATIENT))
    with pytest.raises(BackendError, match="stoi"):
        receiver.open(timeout=4.0)


def test_without_the_wheel_the_error_names_the_extra(monkeypatch):
    monkeypatch.setattr("doorman.hardware.mocap.receiver.find_spec", lambda name: None)
    with pytest.raises(BackendError, match=r"\.\[mocap\]"):
        MocapReceiver(MocapConfig("vehicle", "vrpn:somewhere")).open()


def test_poses_of_a_program_of_ones_own():
    """A lab's own cameras: ten lines that send poses, and the receiver as for Tracker."""
    port, start = free_port(), time.monotonic()
    receiver = MocapReceiver(MocapConfig("vehicle", f"udp:{port}", **PATIENT))
    with PoseSender(("127.0.0.1", port), 100.0) as sender:
        over = threading.Event()

        def stream():
            due = start
            while not over.wait(max(due - time.monotonic(), 0.0)):
                pose = seen(due)
                sender.send({"vehicle": (tuple(pose.position), tuple(pose.quaternion))}, taken=due)
                due += 0.01

        thread = threading.Thread(target=stream, daemon=True)
        thread.start()
        try:
            with receiver:
                sample = receiver.wait(receiver.read(), 1.0)
            assert np.linalg.norm(sample.position - true_position(sample.time)) < 0.012
        finally:
            over.set()
            thread.join()


def test_the_receiver_is_a_pose_source():
    assert isinstance(MocapReceiver(MocapConfig("vehicle")), PoseSource)


@pytest.mark.parametrize(
    ("text", "kind", "settings"),
    [
        ("optitrack:192.168.10.5", "optitrack", {"hostname": "192.168.10.5"}),
        ("optitrack:192.168.10.5:1512", "optitrack", {"hostname": "192.168.10.5", "port_command": "1512"}),
        ("optitrack:10.0.0.5,interface_ip=10.0.0.7", "optitrack", {"hostname": "10.0.0.5", "interface_ip": "10.0.0.7"}),
        ("qualisys://qtm.local:22222", "qualisys", {"hostname": "qtm.local", "port": "22222"}),
        (" vrpn:mocap:3883 ", "vrpn", {"hostname": "mocap:3883"}),
        ("vicon:192.168.10.5", "vicon", {"hostname": "192.168.10.5"}),
    ],
)
def test_cameras_are_parsed(text, kind, settings):
    assert parse_cameras(text) == CamerasLink(kind, settings)
    assert parse_connection(text) == ("127.0.0.1", 0)


@pytest.mark.parametrize(
    "text", ["optitrack:", "optitrack:h:0", "optitrack:h:70000", "nokia:h", "vrpn:h,port", "vrpn:a b"]
)
def test_malformed_cameras_are_refused_with_what_is_allowed(text):
    with pytest.raises(BackendError, match="KIND:HOST"):
        parse_connection(text)


def test_a_stateless_client_sends_only_frames_with_poses(monkeypatch):
    sent = []
    sender = SimpleNamespace(send=sent.append)
    turn = SimpleNamespace(w=1.0, x=0.0, y=0.0, z=0.0)
    body = SimpleNamespace(position=np.float32([1, 2, 3]), rotation=turn)
    for bodies in ({}, {"vehicle": body}):
        cameras = SimpleNamespace(rigidBodies=bodies, waitForNextFrame=lambda: None)
        client.relay(cameras, sender, stateless=True)
    assert sent == [{"vehicle": ((1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0))}]
    client.relay(SimpleNamespace(rigidBodies={}, waitForNextFrame=lambda: None), sender, stateless=False)
    assert sent[-1] == {}


def test_a_client_ends_with_the_thread_that_made_it():
    made: list[ClientProcess] = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as motive:
        motive.bind(("127.0.0.1", 0))
        motive.settimeout(30.0)
        link = CamerasLink("optitrack", {"hostname": "127.0.0.1", "port_command": str(motive.getsockname()[1])})

        def make():
            made.append(ClientProcess(link, 9, 100.0))
            motive.recv(100)  # it has asked to end with us before it calls

        thread = threading.Thread(target=make)
        thread.start()
        thread.join()
        made[0]._process.wait(5.0)
    assert made[0].last_words is not None
    made[0].close()
