"""Sensors of the door: what they say becomes readings, and what cannot be one is none, and told once."""

from __future__ import annotations

import math
import socket
from types import SimpleNamespace

import numpy as np
import pytest
from virtual_time import CLOCK

from doorman.cli.vehicles.rig_demo import free_port
from doorman.exceptions import BackendError
from doorman.hardware.door import (
    CallableSource,
    DoorSample,
    DoorSensor,
    DoorSensorConfig,
    DoorSource,
    FrameSample,
    LeafGeometry,
    LeafSample,
    Mark,
    MarkPose,
    UdpLineSource,
)
from doorman.hardware.door.sources import camera_objects, objects_beside
from doorman.hardware.mocap import MocapConfig, MocapReceiver, PoseSource
from doorman.hardware.vehicle import VehicleLinks, vehicle_config
from doorman.hardware.vehicle_file import VehicleFile
from doorman.kinematics.quaternions import from_rotation
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.rig.emulators.mocap.emulator import BodyPose, MocapEmulator, TrackedBody, TrackerSetup
from doorman.scenario import Scenario

NOW = 50.0
MODEL = Model(Scenario.load("push"))
DOOR = MODEL.door
MOTION = LeafGeometry.of(DOOR)
ANGLE = 1.1


def pose_of(matrix: np.ndarray, **more) -> MarkPose:
    x, y, z = matrix[:3, 3].tolist()
    return MarkPose((x, y, z), from_rotation(matrix[:3, :3]), **more)


def moved(position, yaw: float, roll: float = 0.0) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation_body_to_world((roll, 0.0, yaw)), position
    return matrix


def leaf_at(angle: float) -> np.ndarray:
    return DOOR.link_placements(angle)[DOOR.section.leaf]


def sensor(read, **settings) -> DoorSensor:
    return DoorSensor(CallableSource(read), DoorSensorConfig(source="program", motion=MOTION, **settings))


@pytest.mark.parametrize("name", ["push", "pull", "drawer", "hatch"])
def test_the_leafs_pose_is_a_joint_value(name):
    door = Model(Scenario.load(name)).door
    motion = LeafGeometry.of(door)
    for joint in np.linspace(0.0, 0.3, 4):
        placed = door.link_placements(door.angle_of_joint(joint))[door.section.leaf]
        value, deviation, off, turned = motion.joint(placed[:3, 3], placed[:3, :3], (0.2, 0.1, 0.4), 0.002, 0.01)
        assert value == pytest.approx(joint, abs=1e-9) and off < 1e-9 and turned < 1e-6 and 0.0 < deviation < 0.01


def test_a_joint_value_is_the_reading_with_its_time():
    leaf, frame = sensor(lambda: DoorSample(LeafSample(NOW - 0.02, 0.4))).read(NOW, epoch=40.0)
    assert (leaf.joint, leaf.time, leaf.deviation, frame) == (0.4, pytest.approx(9.98), 0.005, None)


def test_a_frame_that_stands_elsewhere_moves_the_door_and_not_the_leaf():
    elsewhere = moved((0.03, -0.02, 0.01), 0.05)
    sample = DoorSample(LeafSample(NOW, pose=pose_of(elsewhere @ leaf_at(ANGLE))), FrameSample(NOW, pose_of(elsewhere)))
    leaf, frame = sensor(lambda: sample, leaf=Mark("leaf"), frame=Mark("frame")).read(NOW)
    assert leaf.joint == pytest.approx(DOOR.joint_value(ANGLE), abs=1e-9)
    np.testing.assert_allclose(frame.position, (0.03, -0.02, 0.01), atol=1e-12)
    assert frame.yaw == pytest.approx(0.05)
    np.testing.assert_allclose(frame.placed(DOOR.hinge_position), (elsewhere @ [*DOOR.hinge_position, 1.0])[:3])


def test_a_leaf_seen_from_the_vehicle_is_placed_by_the_pose_that_it_had():
    body = moved((-0.8, 0.5, 1.2), 0.3)
    seen = pose_of(np.linalg.inv(body) @ leaf_at(ANGLE), in_body=True)
    one = sensor(lambda: DoorSample(LeafSample(NOW - 0.06, pose=seen)), leaf=Mark("1"))
    for k in range(30):
        at = NOW - 0.2 + 0.01 * k
        one.note_pose(at, body[:3, 3] + (at - NOW + 0.06) * np.array([0.5, 0.0, 0.0]), np.array([0.0, 0.0, 0.3]))
    leaf, _ = one.read(NOW)
    assert leaf.joint == pytest.approx(DOOR.joint_value(ANGLE), abs=1e-6)


def fails() -> DoorSample:
    raise OSError("unplugged")


UPSIDE_DOWN = leaf_at(ANGLE) @ moved((0, 0, 0), 0.0, math.pi)
WAND = moved((2.0, 1.0, 0.3), 1.0)


@pytest.mark.parametrize(
    ("read", "words"),
    [
        (DoorSample, "no reading"),
        (lambda: DoorSample(LeafSample(NOW, math.nan)), "nan"),
        (lambda: DoorSample(LeafSample(NOW - 0.4, 0.4)), "old"),
        (lambda: DoorSample(LeafSample(NOW + 0.1, 0.4)), "time to come"),
        (lambda: DoorSample(LeafSample(NOW, 9.0)), "range"),
        (lambda: DoorSample(LeafSample(NOW, -9.0)), "range"),
        (lambda: DoorSample(LeafSample(NOW, pose=pose_of(UPSIDE_DOWN))), "180° off its way"),
        (lambda: DoorSample(LeafSample(NOW, pose=pose_of(WAND))), "another object"),
        (lambda: DoorSample(LeafSample(NOW, pose=MarkPose((math.nan, 0, 0), (1, 0, 0, 0)))), "not a pose"),
        (lambda: DoorSample(LeafSample(NOW, pose=pose_of(leaf_at(ANGLE), in_body=True))), "not known"),
        (lambda: DoorSample(frame=FrameSample(NOW, pose_of(moved((0, 0, 0), 0.0, math.pi)))), "leans by 180°"),
        (fails, "unplugged"),
    ],
)
def test_what_cannot_be_a_reading_is_none_and_told_once(read, words):
    one = sensor(read, leaf=Mark("leaf"))
    assert all(one.read(NOW) == (None, None) for _ in range(3))
    events = one.events()
    assert len({said for _, said in events}) == len(events) and any(words in said for _, said in events), events


def test_only_changes_are_told():
    samples = [
        DoorSample(),
        DoorSample(),
        DoorSample(LeafSample(NOW, 0.1)),
        DoorSample(LeafSample(NOW, 0.2)),
        DoorSample(),
    ]
    one = sensor(lambda: samples.pop(0))
    readings = [one.read(NOW)[0] for _ in range(5)]
    assert [reading and reading.joint for reading in readings] == [None, None, 0.1, 0.2, None]
    assert len(one.events()) == 3 and not one.events()


def test_a_line_of_text_is_a_reading():
    source = UdpLineSource(f"udp:{free_port()}", CLOCK)
    with pytest.raises(BackendError, match="not open"):
        source.read()
    source.open()
    try:
        assert source.read() == DoorSample()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:

            def said(line: bytes) -> LeafSample:
                sender.sendto(line, source._channel.getsockname())
                return source.read().leaf

            assert said(b"0.52\n").joint == 0.52
            leaf = said(b"joint=0.53 deviation=0.002 age=0.25")
            assert (leaf.joint, leaf.deviation) == (0.53, 0.002) and CLOCK.now() - leaf.time == pytest.approx(
                0.25, abs=0.1
            )
            for line in (b"open", b"joint=nan", b"angle=0.5", b"\xff\xfe"):
                with pytest.raises(BackendError, match="not a line"):
                    said(line)
            assert source.read().leaf.joint == 0.53
    finally:
        source.stop()
        source.stop()


def test_cameras_see_leaf_and_frame_as_further_objects():
    """Through the emulated Tracker: mounts, noise, and an object that goes or takes another's name."""
    port = free_port()
    marks = {"leaf": Mark("door leaf", (0.3, 0.02, 1.1), (0.1, 0.0, 0.2)), "frame": Mark("jamb", (0.4, 0.1, 1.0))}
    truth, stands = {"angle": ANGLE}, moved((0.02, 0.01, 0.0), 0.03)

    def body(matrix) -> BodyPose:
        return BodyPose(matrix[:3, 3], from_rotation(matrix[:3, :3]))

    sources = {
        "leaf": lambda at: body(stands @ leaf_at(truth["angle"])), "frame": lambda at: body(stands)
    }  # fmt: skip
    bodies = {mark.name: TrackedBody(sources[part], mark.position, mark.attitude) for part, mark in marks.items()}
    cameras = MocapConfig("vehicle", f"udp:{port}", stale_after=0.06, prediction_limit=0.2, max_delay=0.05)
    config = DoorSensorConfig(motion=MOTION, **marks)
    emulator = MocapEmulator(
        lambda at: BodyPose((0.1 * math.sin(at), 0.0, 1.0)), TrackerSetup("vehicle", bodies=bodies), ("127.0.0.1", port),
        CLOCK,
    )  # fmt: skip
    receiver = MocapReceiver(cameras, CLOCK, objects_beside(cameras, config))
    one = DoorSensor(camera_objects(receiver), config)
    assert isinstance(one.source, DoorSource) and isinstance(receiver, PoseSource)

    def until(condition):
        end = CLOCK.now() + 5.0
        while not condition(found := one.read(CLOCK.now())):
            assert CLOCK.now() < end, found
            CLOCK.sleep(0.01)
        return found

    with emulator, receiver:
        leaf, frame = until(lambda found: None not in found)
        assert leaf.joint == pytest.approx(DOOR.joint_value(ANGLE), abs=1e-3)
        np.testing.assert_allclose(frame.position, (0.02, 0.01, 0.0), atol=1e-3)
        assert frame.yaw == pytest.approx(0.03, abs=1e-3) and CLOCK.now() - leaf.time < 0.05
        truth["angle"] = ANGLE - 0.02
        until(lambda found: found[0] is not None and abs(found[0].joint - DOOR.joint_value(ANGLE - 0.02)) < 1e-3)
        emulator.stream.faults_of["door leaf"].frozen = True
        until(lambda found: found[0] is None and found[1] is not None)
        assert receiver.read().fresh
        emulator.stream.faults_of["door leaf"].frozen = False
        until(lambda found: found[0] is not None)
        emulator.stream.faults_of["door leaf"].absent = True
        until(lambda found: found[0] is None)
    assert any("no reading" in words for _, words in one.events())


def test_a_vehicle_file_names_the_sensor(tmp_path):
    file = tmp_path / "mine.toml"
    text = '[pixhawk]\nconnection = "udp:14540"\n[servos]\nport = "/dev/null"\n[mocap]\nconnection = "udp:51001"\n'
    file.write_text(
        text + '[door_sensor]\nleaf = { name = "leaf", position = [0.1, 0.2, 0.3] }\nframe = { name = "frame" }\n'
    )
    config = VehicleFile.load(file).links(MODEL)
    assert config.door_sensor.leaf == Mark("leaf", (0.1, 0.2, 0.3)) and config.door_sensor.motion == MOTION
    assert set(VehicleLinks(config).mocap.beside) == {"leaf", "frame"}
    file.write_text(text + '[door_sensor]\nsource = "tags"\n')
    with pytest.raises(BackendError, match="leaf, frame"):
        VehicleFile.load(file).links(MODEL)
    file.write_text(text.replace('"udp:51001"', '"none"') + '[door_sensor]\nleaf = { name = "leaf" }\n')
    with pytest.raises(BackendError, match="no cameras"):
        VehicleFile.load(file).links(MODEL)


def test_a_source_of_ones_own_is_accepted():
    source = CallableSource(lambda: DoorSample(LeafSample(NOW, 0.4)))
    with pytest.raises(BackendError, match="how the leaf moves"):
        VehicleLinks(vehicle_config(MODEL, "udp:14540", "/dev/null"), door=source)
    config = vehicle_config(MODEL, "udp:14540", "/dev/null", links={"door_sensor.source": "program"})
    assert VehicleLinks(config, door=source).door.read(NOW)[0].joint == 0.4
    with pytest.raises(BackendError, match="hand on the source"):
        VehicleLinks(config)


def test_the_journal_tells_of_the_door():
    from doorman.flight.journal import Journal
    from doorman.recording import Recorder

    one, silent = sensor(DoorSample, leaf=Mark("leaf")), SimpleNamespace(events=list)
    one.read(NOW)
    links = SimpleNamespace(autopilot=silent, servos=silent, mocap=None, tip_force=None, door=one)
    journal = Journal(links, SimpleNamespace(findings=[]), Recorder(None, {}))
    journal.take(math.nan)
    assert "door_sensor: leaf: no reading" in journal.lines[0]
