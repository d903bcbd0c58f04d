"""Faults of the bridge on loopback: datagrams of strangers, a second publisher, poses that cannot be read, parts that die."""

from __future__ import annotations

import json
import math
import signal
import socket
import struct
import time
from collections import Counter
from collections.abc import Iterator

import numpy as np
import pytest
from command_line import run as doorman
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from test_ros2 import domain, free_port, measurement, stepping  # noqa: F401

from doorman.exceptions import BackendError
from doorman.hardware.mocap import MocapFault
from doorman.ros2 import Feed
from doorman.ros2 import types as ros
from doorman.ros2.bridge import FlightPublisher, PoseSubscriber, dds_name
from doorman.ros2.feed import FedMessage, parse
from doorman.ros2.messages import Translator

TOPIC = "/vrpn/vehicle/pose"
EMPTY = b'"position":[],"velocity":[],"attitude":[],"body_rates":[],"arm_angles":[],"arm_rates":[]'
GOOD = json.dumps({name: values.tolist() for name, values in measurement(1).items()}).encode()
MISSION = b'{"state":"open","message":""}'
STRANGE = [
    b'["measurement",1e400,{' + EMPTY + b"}]", b'["measurement",1,{' + EMPTY + b"}]", b"[" * 30_000,
    b'["mission",9223372036854775807,' + MISSION + b"]", b'["mission",99999999999999999999999,' + MISSION + b"]",
    b'["mission",-1,' + MISSION + b"]", b'["mission","5",' + MISSION + b"]", b'["mission",true,' + MISSION + b"]",
    b'["mission",1.5,' + MISSION + b"]", b'["mission",null,' + MISSION + b"]", b'["mission",1,{"state":1,"message":[]}]',
    b'["mission",1,{"state":"\\ud800","message":""}]', b'["plan",1,{"states":[]}]', b'["plan",1,{"states":[[]]}]',
    b'["plan",1,{"states":[[1],[1,2]]}]', b'["plan",1,{"states":[1,2,3]}]', b'["plan",1,{"states":7}]',
    b'["plan",1,{"states":[[1,2,3,4,5,6,7,8,9,10,11,12]]}]', b'["estimate",1,{"state":[0],"tip_force":[0,0,0]}]',
    b'["measurement",1,' + GOOD.replace(b"2.0", b'"2.0"') + b"]", b'["measurement",1,' + GOOD.replace(b"2.0", b"1e999") + b"]",
    b'["measurement",1,' + GOOD.replace(b"2.0", b"{}") + b"]", b'[["measurement"],1,{}]', b'{"a":1}', b'"abc"', b"\0" * 100,
    b"", b"[]", b'["truth", 1, {}]', b'["plan", 1, {}]', b"\xff", b'["plan", 1]', b"3",
]  # fmt: skip


def pose(x: float, frame: str = "map", at: float | None = None) -> ros.PoseStamped:
    at = time.time() if at is None else at
    stamp = ros.Time(int(at), int(at % 1.0 * 1e9))
    place = ros.Point(x, 0.3 + 1e-5 * math.sin(1e5 * time.monotonic()), 1.0)
    return ros.PoseStamped(ros.Header(stamp, frame), ros.Pose(place, ros.Quaternion(0.0, 0.0, 0.0, 1.0)))


class Publisher:
    """Of poses, on the graph of a test."""

    def __init__(self, number: int) -> None:
        self._participant = DomainParticipant(number)
        self._writer = DataWriter(self._participant, Topic(self._participant, dds_name(TOPIC), ros.PoseStamped))
        end = time.monotonic() + 10.0
        while not self._writer.get_matched_subscriptions():
            assert time.monotonic() < end
            time.sleep(0.02)

    def write(self, message: ros.PoseStamped) -> None:
        self._writer.write(message)


class Bytes(str):
    """A text whose bytes are none in UTF-8, as a node in another language may send them."""

    def encode(self, *_: str) -> bytes:
        return b"\xff\xfe"


@pytest.fixture
def flight() -> Iterator[socket.socket]:
    """Where poses are sent to."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as channel:
        channel.bind(("127.0.0.1", 0))
        channel.setblocking(False)
        yield channel


def forwarded(channel: socket.socket) -> Counter[float]:
    """Poses on the wire by their x [mm]."""
    found: Counter[float] = Counter()
    while True:
        try:
            found[struct.unpack_from("<d", channel.recv(65536), 5 + 3 + 24)[0]] += 1
        except BlockingIOError:
            return found


@pytest.mark.parametrize("data", STRANGE, ids=range(len(STRANGE)))
def test_datagrams_of_strangers_are_left_out(data, model):
    told = parse(data)
    if told is not None:
        with pytest.raises(BackendError, match="another scenario"):
            list(Translator(model).translate(told))


def test_the_bridge_goes_on_after_datagrams_of_strangers(model, domain):  # noqa: F811
    with FlightPublisher(model, 0, domain) as bridge, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        for data in STRANGE:
            stranger.sendto(data, ("127.0.0.1", bridge.port))
            bridge.step(1.0)
        assert (bridge.refusals.total(), bridge.published) == (len(STRANGE), 0)
        with Feed(bridge.port) as feed:
            feed.listen("measurement", 0.0, measurement(1))
            bridge.step(1.0)
        assert (bridge.refusals.total(), bridge.published) == (len(STRANGE), 1)


def test_a_flight_of_another_vehicle_is_told_what_differs(model):
    told = FedMessage("measurement", 1, measurement(1) | {"arm_angles": np.zeros(2)})
    with pytest.raises(BackendError) as caught:
        list(Translator(model).translate(told))
    assert (caught.value.field, caught.value.given) == ("measurement.arm_angles", 2)


def test_of_two_publishers_one_is_flown_on_and_the_other_told(domain, flight):  # noqa: F811
    with PoseSubscriber(TOPIC, "vehicle", flight.getsockname(), 100.0, domain) as bridge:
        first, second = Publisher(domain), Publisher(domain)
        with stepping(bridge):
            for k in range(100):
                first.write(pose(0.0))
                time.sleep(0.005)
                if k >= 5:
                    second.write(pose(3.0))
                time.sleep(0.005)
            time.sleep(0.1)
        wire = forwarded(flight)
        assert wire.keys() == {0.0} and wire[0.0] > 80
        assert bridge.relay.refused == 95
        assert {event.fault for event in bridge.relay.events()} == {MocapFault.FOREIGN}


def test_a_message_that_cannot_be_read_costs_itself(domain, flight):  # noqa: F811
    with PoseSubscriber(TOPIC, "vehicle", flight.getsockname(), 100.0, domain) as bridge:
        publisher = Publisher(domain)
        for k in range(10):
            publisher.write(pose(0.1 * k, Bytes("??") if k % 3 == 1 else "map"))
            time.sleep(0.012)
        end = time.monotonic() + 10.0
        while bridge.relay.received + bridge.relay.refused < 10 and time.monotonic() < end:
            bridge.step(0.1)
        assert (bridge.relay.received, bridge.relay.refused) == (7, 3)
        assert [event.fault for event in bridge.relay.events()][0] is MocapFault.CORRUPT


@pytest.fixture
def signals() -> Iterator[None]:
    """The command's answers to signals end with the test."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def dies(*_: object) -> None:
    raise RuntimeError("the part is dead")


@pytest.mark.parametrize("part", ["FlightPublisher", "PoseSubscriber"])
def test_a_part_that_dies_ends_the_bridge_with_an_error(part, domain, signals, monkeypatch):  # noqa: F811
    monkeypatch.setattr(f"doorman.ros2.bridge.{part}.step", dies)
    result = doorman(
        "ros2", "paper", "--feed", "0", "--domain", str(domain), "--poses", TOPIC, "--to", str(free_port())
    )
    assert result.exit_code == 3
    assert "the part is dead" in result.stderr
