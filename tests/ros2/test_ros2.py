"""The bridge on loopback, against a participant of its own process that knows ROS 2's messages from rosbags alone."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import random
import re
import socket
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
import yaml
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
from doorman.ros2.messages import WORLD, Translator
from doorman.ros2.topics import TOPICS

LOOPBACK = (
    '<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces></General>'
    "</Domain></CycloneDDS>"
)
BEHIND = 50
"""Messages that the listener may be behind: fewer than the publisher keeps for it."""
INDEPENDENT = Path(__file__).parent / "independent.py"
STORE = get_typestore(Stores.ROS2_HUMBLE)
NAMES = {topic.name: topic.type_name.replace("/", "/msg/") for topic in TOPICS}
KNOWN = {"odometry": "nav_msgs/msg/Odometry", "joint_states": "sensor_msgs/msg/JointState", "plan": "nav_msgs/msg/Path",
         "tip_force": "geometry_msgs/msg/WrenchStamped", "mission": "std_msgs/msg/String", "/tf": "tf2_msgs/msg/TFMessage",
         "/clock": "rosgraph_msgs/msg/Clock", "/robot_description": "std_msgs/msg/String", "/tf_static": "tf2_msgs/msg/TFMessage",
         "markers": "visualization_msgs/msg/MarkerArray", "door/joint_states": "sensor_msgs/msg/JointState"}  # fmt: skip
"""As other nodes of ROS expect them."""


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


def heard(listener):
    """The next message that a participant has heard."""
    return json.loads(listener.stdout.readline())


def matrix(transform):
    """Homogeneous matrix of a message's transform."""
    place, turn = transform["translation"], transform["rotation"]
    return pin.XYZQUATToSE3(np.array([*place.values(), *turn.values()])).homogeneous


def transforms(message):
    """Transforms of a message, as rosbags reads its bytes."""
    return plain(STORE.deserialize_cdr(message.serialize(), NAMES["/tf"]))["transforms"]


def plain(value):
    if hasattr(value, "__dataclass_fields__"):
        return {name: plain(getattr(value, name)) for name in value.__dataclass_fields__ if name != "__msgtype__"}
    return [plain(one) for one in value] if isinstance(value, list) else value


@pytest.mark.parametrize("name", NAMES)
def test_types_and_bytes_are_those_of_ros(name, model):
    """Every message is the same bytes as rosbags writes for the same values."""
    told = {
        "odometry": FedMessage("measurement", 5_000_000_007, measurement(1)),
        "plan": FedMessage("plan", 7, {"states": np.tile(model.start_state, (3, 1))}),
        "tip_force": FedMessage("estimate", 7, {"state": model.start_state, "tip_force": np.array([1.0, -2.0, 3.0])}),
        "mission": FedMessage("mission", 7, {"state": "open", "message": "now"}),
        "door/measured_joint_states": FedMessage("door_sensor", 7, {"joint": 0.52, "deviation": 0.002}),
        "/clock": FedMessage("truth", 7, {}, 1.25),
    }
    told |= {"/tf": told["odometry"], "joint_states": told["odometry"], "markers": told["tip_force"]}
    told["door/joint_states"] = told["tip_force"]
    translator = Translator(model)
    sent = translator.translate(told[name]) if name in told else translator.at_the_start()
    (message,) = [one.message for one in sent if one.topic == name]
    data = message.serialize()
    read = STORE.deserialize_cdr(data, NAMES[name])
    assert bytes(STORE.serialize_cdr(read, NAMES[name])) == bytes(data)
    package, _, short = NAMES[name].split("/")
    assert type(message).__idl_typename__ == f"{package}.msg.dds_.{short}_"
    assert KNOWN.get(name, NAMES[name]) == NAMES[name]


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
    linear = first["twist"]["twist"]["linear"]  # in the child's frame
    expected = rotation_body_to_world([0.1, -0.2, 1.5]).T @ [1.0, 0.0, 0.0]
    np.testing.assert_allclose([linear["x"], linear["y"], linear["z"]], expected)


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
    assert bridge.relay.received > 20 and bridge.relay.refused == 0


def test_a_flight_that_is_fed_is_published(model, domain):
    with FlightPublisher(model, 0, domain) as bridge, Feed(bridge.port) as feed:
        with stepping(bridge):
            recording = simulate(model, duration=1.0, listener=feed.listen)
            fed = sum(len(recording[topic].time) for topic in ("truth", "measurement", "estimate", "plan", "mission"))
            until(lambda: bridge.published + feed.unsent >= fed)
        assert (bridge.published, bridge.refusals.total(), feed.unsent) == (fed, 0, 0)


@pytest.mark.parametrize("name", ["/robot_description", "/tf_static", "mission"])
def test_who_comes_late_hears_what_is_kept(model, domain, name):
    """A participant that starts after the messages were sent."""
    with FlightPublisher(model, 0, domain) as bridge, Feed(bridge.port) as feed, stepping(bridge):
        feed.listen("mission", 0.0, {"state": "approach", "message": ""})
        feed.listen("mission", 0.1, {"state": "open", "message": "now"})
        until(lambda: bridge.published == 2)
        topic = next(one for one in TOPICS if one.name == name)
        with participant("listen", domain, NAMES[name], dds_name(topic.under("doorman")), 1, "latched") as listener:
            assert listener.stdout.readline() == "ready\n"
            message = heard(listener)
    if name == "mission":
        assert message == {"data": "open: now"}
    elif name == "/tf_static":
        names = {one["child_frame_id"] for one in message["transforms"]}
        assert {"rotor_1", "door/frame"} <= names and "base_link" not in names
    else:
        assert message["data"].startswith("<robot") and 'joint name="eta_1"' in message["data"]


def test_the_frames_lead_from_the_map_to_tip_and_leaf(model):
    """What other nodes make of the transforms is what doorman's own kinematics says; every frame has one parent."""
    translator, state = Translator(model), model.start_state
    measured = {"position": np.array([0.3, -0.2, 1.1]), "velocity": np.zeros(3), "attitude": np.array([0.1, -0.2, 1.5]),
                "body_rates": np.zeros(3), "arm_angles": state[5:] + 0.2, "arm_rates": np.zeros(4)}  # fmt: skip
    told = [*translator.at_the_start(), *translator.translate(FedMessage("measurement", 7, measured))]
    told += translator.translate(FedMessage("estimate", 7, {"state": state, "tip_force": np.zeros(3)}))
    parents = {}
    for one in told:
        if one.topic in ("/tf", "/tf_static"):
            for each in transforms(one.message):
                assert each["child_frame_id"] not in parents
                parents[each["child_frame_id"]] = each["header"]["frame_id"], matrix(each["transform"])
    places = {}
    for name in ("tip", "door/leaf"):
        at, placed = name, np.eye(4)
        while at != "map":
            at, step = parents[at]
            placed = step @ placed
        places[name] = placed
    tip = measured["position"] + rotation_body_to_world(measured["attitude"]) @ model.vehicle.tip_position(
        measured["arm_angles"]
    )
    np.testing.assert_allclose(places["tip"][:3, 3], tip, atol=1e-9)
    np.testing.assert_allclose(places["door/leaf"], model.door.link_placements(state[3])["leaf"], atol=1e-9)


def test_stamps_are_simulated_time_where_time_is_simulated(model):
    translator, fields = Translator(model), measurement(1)
    clock, *_ = translator.translate(FedMessage("truth", 10**18, {}, 2.5))
    assert (clock.topic, clock.message.clock.sec, clock.message.clock.nanosec) == ("/clock", 2, 500_000_000)
    stamps = []
    for wall in (10**18 + 5, 10**18 + 2 * 10**9):  # the second long after the simulation has ended
        sent = {one.topic: one.message for one in translator.translate(FedMessage("measurement", wall, fields, 2.5))}
        stamps.append(sent["/tf"].transforms[0].header.stamp)
    assert (stamps[0].sec, stamps[0].nanosec) == (2, 500_000_000) and stamps[1].sec == 10**9 + 2


SHOWN = Path(__file__).parents[2] / "examples" / "ros2"
KINDS = {"RobotModel": "std_msgs/String", "Path": "nav_msgs/Path", "MarkerArray": "visualization_msgs/MarkerArray"}
"""What RViz's displays take."""


def published(model):
    """Messages of all kinds, by full name of their topic."""
    translator, state = Translator(model), model.start_state
    told = [*translator.at_the_start(), *translator.translate(FedMessage("measurement", 7, measurement(1)))]
    told += translator.translate(FedMessage("estimate", 7, {"state": state, "tip_force": np.ones(3)}))
    names = {topic.name: topic.under("doorman") for topic in TOPICS}
    return [(names[one.topic], one.message) for one in told]


def series(name, value):
    """Names that PlotJuggler gives to the numbers of a message; those of a JointState by the joint's name."""
    if isinstance(value, ros.JointState):
        joints = {"position": value.position, "velocity": value.velocity}
        return {
            f"{name}/{joint}/{kind}" for kind, have in joints.items() for joint, _ in zip(value.name, have, strict=True)
        }
    if dataclasses.is_dataclass(value):
        return set().union(
            *(series(f"{name}/{one.name}", getattr(value, one.name)) for one in dataclasses.fields(value))
        )
    return {name} if isinstance(value, float) else set()


def test_what_plotjuggler_draws_is_a_number_of_a_message(model):
    curves = re.findall(r'curve name="([^"]+)"', (SHOWN / "plotjuggler.xml").read_text(encoding="utf-8"))
    numbers = set().union(*(series(*one) for one in published(model)))
    assert len(curves) > 10 and set(curves) <= numbers


def test_rviz_shows_topics_as_they_are_published_in_frames_that_exist(model):
    """Types, durability and namespaces of its displays; and every link of both URDFs has a transform."""
    manager = yaml.safe_load((SHOWN / "doorman.rviz").read_text(encoding="utf-8"))["Visualization Manager"]
    topics, messages = {topic.under("doorman"): topic for topic in TOPICS}, published(model)
    frames = {each.child_frame_id for name, one in messages if name in ("/tf", "/tf_static") for each in one.transforms}
    assert manager["Global Options"]["Fixed Frame"] == WORLD
    displays = {one["Name"]: one for one in manager["Displays"] if "Topic" in one or "Description Topic" in one}
    assert displays.keys() == {"vehicle", "door", "plan", "tip force"}
    for one in displays.values():
        asked = one.get("Topic") or one["Description Topic"]
        topic, kind = topics[asked["Value"]], one["Class"].rpartition("/")[2]
        assert topic.type_name == KINDS[kind] and asked["Reliability Policy"] == "Reliable"
        assert asked["Durability Policy"] == ("Transient Local" if topic.latched else "Volatile")
        shown = [message for name, message in messages if name == asked["Value"]]
        if kind == "RobotModel":
            prefix = f"{one['TF Prefix']}/" if one["TF Prefix"] else ""
            links = {f"{prefix}{link.get('name')}" for link in ElementTree.fromstring(shown[0].data).iter("link")}
            assert links - {f"{prefix}world"} <= frames
        elif kind == "MarkerArray":
            assert set(one["Namespaces"]) == {marker.ns for marker in shown[0].markers}


def test_the_plan_ends_where_the_planner_ends(model):
    states = np.tile(model.start_state, (5, 1))
    translator = Translator(model)
    (path,) = [one.message for one in translator.translate(FedMessage("plan", 0, {"states": states}))]
    place = path.poses[-1].pose.position
    expected = model.coupling.vehicle_position(states[0, :3], states[0, 3], states[0, 5:])
    np.testing.assert_allclose([place.x, place.y, place.z], expected)
    assert list(translator.translate(FedMessage("plan", 1000, {"states": states}))) == []  # seldom


def test_the_arrow_begins_at_the_contact_point(model):
    told = FedMessage("estimate", 0, {"state": model.start_state, "tip_force": np.array([1.0, 0.0, 0.0])})
    (markers,) = [one.message for one in Translator(model).translate(told) if one.topic == "markers"]
    (arrow,) = markers.markers
    begin, end = ([point.x, point.y, point.z] for point in arrow.points)
    assert begin == pytest.approx(list(model.coupling.contact_point(model.start_angle)))
    assert end == pytest.approx([begin[0] + 0.06, *begin[1:]])


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
            stranger.sendto(b'["mission",1e400,{"state":"","message":""},0.0]', ("127.0.0.1", port))
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
