"""The bridge on loopback, against a participant of its own process that knows ROS 2's messages from rosbags alone."""

from __future__ import annotations

import json
import math
import os
import random
import socket
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from command_line import run as doorman
from rosbags.typesys import Stores, get_typestore

from doorman.exceptions import BackendError
from doorman.hardware.mocap import MocapConfig, MocapReceiver
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.mission import simulate
from doorman.ros2 import Feed
from doorman.ros2 import types as ros
from doorman.ros2.bridge import FlightPublisher, PoseSubscriber, dds_name
from doorman.ros2.door_source import JointStateSource
from doorman.ros2.feed import FedMessage, parse
from doorman.ros2.messages import TYPES, Translator

LOOPBACK = (
    '<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces></General>'
    "</Domain></CycloneDDS>"
)
BEHIND = 50
"""Messages that the listener may be behind: fewer than the publisher keeps for it."""
INDEPENDENT = Path(__file__).parent / "independent.py"
STORE = get_typestore(Stores.ROS2_HUMBLE)
NAMES = {"odometry": "nav_msgs/msg/Odometry", "joint_states": "sensor_msgs/msg/JointState", "plan": "nav_msgs/msg/Path",
         "tip_force": "geometry_msgs/msg/WrenchStamped", "mission": "std_msgs/msg/String", "tf": "tf2_msgs/msg/TFMessage",
         "markers": "visualization_msgs/msg/MarkerArray", "door/joint_states": "sensor_msgs/msg/JointState"}  # fmt: skip


@pytest.fixture
def domain(monkeypatch):
    """Of this test alone, on loopback."""
    monkeypatch.setenv("CYCLONEDDS_URI", LOOPBACK)
    return random.Random(os.getpid() + time.monotonic_ns()).randrange(1, 200)


@contextmanager
def stepping(bridge):
    over = threading.Event()

    def work():
        while not over.is_set():
            bridge.step(0.05)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join(2.0)


def until(condition):
    """Wait for what other processes and threads do; an error if it does not come."""
    end = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


@contextmanager
def participant(*arguments):
    process = subprocess.Popen(
        [sys.executable, str(INDEPENDENT), *map(str, arguments)], stdout=subprocess.PIPE, text=True
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def measurement(index):
    state = {"position": [0.1 * index, 2.0, 3.0], "velocity": [1.0, 0.0, 0.0], "attitude": [0.1, -0.2, 1.5],
             "body_rates": [0.4, 0.5, 0.6], "arm_angles": [0.1, 0.2, 0.3, 0.4], "arm_rates": [0.0, 0.0, 0.0, 0.1]}  # fmt: skip
    return {name: np.array(values) for name, values in state.items()}


@pytest.mark.parametrize("name", NAMES)
def test_types_and_bytes_are_those_of_ros(name, model):
    """Every message is the same bytes as rosbags writes for the same values."""
    told = {
        "odometry": FedMessage("measurement", 5_000_000_007, measurement(1)),
        "plan": FedMessage("plan", 7, {"states": np.tile(model.start_state, (3, 1))}),
        "tip_force": FedMessage("estimate", 7, {"state": model.start_state, "tip_force": np.array([1.0, -2.0, 3.0])}),
        "mission": FedMessage("mission", 7, {"state": "open", "message": "now"}),
        "door/joint_states": FedMessage("door_sensor", 7, {"joint": 0.52, "deviation": 0.002}),
    }
    told |= {"tf": told["odometry"], "joint_states": told["odometry"], "markers": told["tip_force"]}
    (message,) = [one.message for one in Translator(model).translate(told[name]) if one.topic == name]
    data = message.serialize()
    read = STORE.deserialize_cdr(data, NAMES[name])
    assert bytes(STORE.serialize_cdr(read, NAMES[name])) == bytes(data)
    package, _, short = NAMES[name].split("/")
    assert TYPES[name].__idl_typename__ == f"{package}.msg.dds_.{short}_"


def test_a_joint_of_ros_is_a_source_of_the_door():
    """Messages of an encoder's node, by name and stamp; what has no such joint says so."""
    source = JointStateSource("/door/joint_states", "hinge")
    with pytest.raises(BackendError, match="not open"):
        source.read()
    now, stamp = time.monotonic(), time.time() - 0.2
    header = ros.Header(ros.Time(int(stamp), int(stamp % 1.0 * 1e9)), "")
    leaf = source._leaf(ros.JointState(header, ["latch", "hinge"], [0.1, 0.52], [], []))
    assert leaf.joint == 0.52 and now - leaf.time == pytest.approx(0.2, abs=0.15)
    with pytest.raises(BackendError, match="not in the messages"):
        source._leaf(ros.JointState(header, ["latch"], [0.1], [], []))
    source.stop()


def test_poses_have_the_type_of_ros():
    stamped = ros.PoseStamped(
        ros.Header(ros.Time(1, 2), "map"), ros.Pose(ros.Point(1.0, 2.0, 3.0), ros.Quaternion(0.0, 0.6, 0.0, 0.8))
    )
    read = STORE.deserialize_cdr(stamped.serialize(), "geometry_msgs/msg/PoseStamped")
    assert (read.pose.position.z, read.pose.orientation.w, read.header.stamp.nanosec) == (3.0, 0.8, 2)


def test_two_hundred_a_second_arrive_all(model, domain):
    count = 400
    with FlightPublisher(model, 0, domain) as bridge, Feed(bridge.port) as feed, stepping(bridge):
        with participant("listen", domain, NAMES["odometry"], dds_name("doorman/odometry"), count) as listener:
            assert listener.stdout.readline() == "ready\n"
            until(bridge._writers["odometry"].get_matched_subscriptions)
            start, heard = time.monotonic(), []
            for index in range(count):
                time.sleep(max(start + 0.005 * index - time.monotonic(), 0.0))
                feed.listen("measurement", 0.005 * index, measurement(index))
                if index >= BEHIND:  # a busy machine may take longer, not lose any
                    heard.append(json.loads(listener.stdout.readline()))
            heard += [json.loads(listener.stdout.readline()) for _ in range(BEHIND)]
    places = [one["pose"]["pose"]["position"]["x"] for one in heard]
    assert places == pytest.approx([0.1 * index for index in range(count)])
    first = heard[0]
    assert (first["header"]["frame_id"], first["child_frame_id"]) == ("map", "base_link")
    assert abs(first["header"]["stamp"]["sec"] - time.time()) < 60.0
    turn = first["pose"]["pose"]["orientation"]
    w, v = turn["w"], np.array([turn["x"], turn["y"], turn["z"]])
    rotation = rotation_body_to_world([0.1, -0.2, 1.5])
    axis = np.array([0.3, 0.7, -0.2])
    np.testing.assert_allclose(axis + 2 * w * np.cross(v, axis) + 2 * np.cross(v, np.cross(v, axis)), rotation @ axis)
    linear = first["twist"]["twist"]["linear"]
    np.testing.assert_allclose([linear["x"], linear["y"], linear["z"]], rotation.T @ [1.0, 0.0, 0.0])


def test_poses_of_ros_reach_the_receiver_of_cameras(domain):
    with PoseSubscriber("/vrpn/vehicle/pose", "vehicle", ("127.0.0.1", port := free_port()), 100.0, domain) as bridge:
        receiver = MocapReceiver(
            MocapConfig("vehicle", f"udp:{port}", latency=0.0, stale_after=0.06, prediction_limit=0.2, max_delay=0.05)
        )
        with stepping(bridge), participant("send", domain, dds_name("vrpn/vehicle/pose"), 10_000):
            receiver.open(60.0)
            try:
                sample, right, end = receiver.read(), 0, time.monotonic() + 60.0
                while right < 20:  # in a row: until one comes without delay, all of them count as later than they are
                    assert time.monotonic() < end, sample
                    sample = receiver.wait(sample, 20.0)
                    there = [0.4 * math.sin(sample.time), 0.3, 1.0]
                    right = right + 1 if np.allclose(sample.position, there, rtol=0.0, atol=0.012) else 0
            finally:
                receiver.stop()
    assert bridge.received > 20 and bridge.refused == 0


def test_a_flight_that_is_fed_is_published(model, domain):
    with FlightPublisher(model, 0, domain) as bridge, Feed(bridge.port) as feed:
        with stepping(bridge):
            recording = simulate(model, duration=1.0, listener=feed.listen)
            fed = sum(len(recording[topic].time) for topic in ("measurement", "estimate", "plan", "mission"))
            until(lambda: bridge.published + feed.unsent >= fed)
        assert (bridge.published, bridge.refused, feed.unsent) == (fed, 0, 0)


def test_the_plan_ends_where_the_planner_ends(model):
    states = np.tile(model.start_state, (5, 1))
    translator = Translator(model)
    (path,) = [one.message for one in translator.translate(FedMessage("plan", 0, {"states": states}))]
    place = path.poses[-1].pose.position
    expected = model.coupling.vehicle_position(states[0, :3], states[0, 3], states[0, 5:])
    np.testing.assert_allclose([place.x, place.y, place.z], expected)
    assert list(translator.translate(FedMessage("plan", 1000, {"states": states}))) == []  # seldom


def test_the_leaf_is_where_the_door_is(model):
    told = FedMessage("estimate", 0, {"state": model.start_state, "tip_force": np.array([0.0, 0.0, 0.0])})
    (markers,) = [one.message for one in Translator(model).translate(told) if one.topic == "markers"]
    leaf, arrow = markers.markers
    middle = [leaf.pose.position.x, leaf.pose.position.y, leaf.pose.position.z]
    door, angle = model.door, model.start_angle
    foot = door.hinge_position + 0.5 * door.width * door.leaf_direction(angle)
    np.testing.assert_allclose(middle, foot + [0.0, 0.0, 0.5 * door.height])
    assert leaf.scale.z == pytest.approx(door.height)
    assert [arrow.points[0].x, arrow.points[0].y] == pytest.approx(list(model.coupling.contact_point(angle)[:2]))


@pytest.mark.parametrize("data", [b"", b"[]", b'["truth", 1, {}]', b'["plan", 1, {}]', b"\xff", b'["plan", 1]', b"3"])
def test_what_no_feed_has_sent_is_refused(data):
    assert parse(data) is None


def test_nan_stays_nan():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        with Feed(listener.getsockname()[1]) as feed:
            feed.listen(
                "estimate", 0.0, {"state": np.zeros(9), "tip_force": np.array([1.0, math.nan, 3.0]), "wind": 1.0}
            )
            told = parse(listener.recv(60_000))
    np.testing.assert_array_equal(told.fields["tip_force"], [1.0, math.nan, 3.0])


def test_a_feed_without_a_bridge_costs_nothing():
    with Feed(free_port()) as feed:
        for index in range(5):
            feed.listen("mission", 0.0, {"state": "open", "message": str(index)})
        assert feed.unsent > 0


def test_a_port_that_is_taken(model, domain):
    with FlightPublisher(model, 0, domain) as bridge, pytest.raises(BackendError, match="cannot listen"):
        FlightPublisher(model, bridge.port, domain)


def test_the_command_says_how_to_feed_it(domain, tmp_path):
    port = free_port()
    process = subprocess.Popen(
        [sys.executable, "-m", "doorman", "ros2", "paper", "--feed", str(port), "--domain", str(domain)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        assert f"--feed {port}" in process.stdout.readline()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            stranger.sendto(b'["mission",1e400,{"state":"","message":""}]', ("127.0.0.1", port))
        assert "left out" in process.stderr.readline()
        process.terminate()
        assert "Published 0 messages" in process.communicate(timeout=60.0)[0]
        assert process.returncode == 0
    finally:
        process.kill()
    assert doorman("ros2", "--feed", "70000").exit_code == 2


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]
