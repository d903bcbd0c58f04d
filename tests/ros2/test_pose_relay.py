"""Poses of ROS 2 that lie about their time, their sender or themselves, judged as the flight's receiver judges them.

Time is virtual: the relay's datagrams go through the receiver's pipeline at the times that the test says.
"""

from __future__ import annotations

import math
import socket
from collections import Counter
from collections.abc import Iterator

import numpy as np
import pytest

from doorman.background import EventLog
from doorman.hardware.mocap import MocapConfig, MocapFault, PoseQuality, PoseSample
from doorman.hardware.mocap.tracker import Pipeline
from doorman.ros2.relay import PoseRelay

PERIOD = 0.01
LATE = 0.002
"""Of the graph and the relay [s]."""
WALL = 1.7e9
"""Of the publisher's clock when the test's begins [s]."""
FIRST, SECOND = 7, 8
"""Handles of publishers."""


def place(at: float) -> tuple[float, float, float]:
    return 0.4 * math.sin(at), 0.3 * math.cos(1.3 * at), 1.0


class Flight:
    """A relay with the receiver behind it."""

    def __init__(self) -> None:
        self.channel = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.channel.bind(("127.0.0.1", 0))
        self.channel.setblocking(False)
        self.relay = PoseRelay("vehicle", self.channel.getsockname(), 1.0 / PERIOD)
        self.config = MocapConfig("vehicle", latency=LATE)
        self.pipeline = Pipeline(self.config, EventLog())
        self.now = 100.0
        self.forwarded: Counter[float] = Counter()
        self.ages: list[float] = []

    def close(self) -> None:
        self.relay.close()
        self.channel.close()

    @property
    def counts(self) -> Counter[MocapFault]:
        return self.pipeline.book.counts

    def read(self) -> PoseSample:
        return self.pipeline.latest.at(self.now, self.config.stale_after, self.config.prediction_limit)

    def pose(self, stamp: float | None, publisher: int = FIRST, aside: float = 0.0, quaternion=(1.0, 0.0, 0.0, 0.0)):
        """A pose of now that arrives a little later; what is flown on is true, to the age that it says."""
        x, y, z = place(self.now)
        self.now += LATE
        self.relay.take(publisher, (x + aside, y, z), quaternion, stamp, self.now)
        self._receive()
        self.now -= LATE

    def _receive(self) -> None:
        before = self.pipeline.latest.count
        while True:
            try:
                datagram, sender = self.channel.recvfrom(65536)
            except BlockingIOError:
                break
            self.pipeline.feed(datagram, sender, self.now, self.now)
        self.pipeline.tick(self.now)
        self.relay.tick(self.now)
        if self.pipeline.latest.count > before:
            sample = self.read()
            assert np.linalg.norm(sample.position - place(sample.time)) < 0.02, f"flown on a wrong pose at {self.now}"

    def fly(self, frames: int, ahead: float | None = 0.0, **given) -> None:
        """Poses whose stamps are so far ahead of the publisher's right clock; None: without stamps."""
        for _ in range(frames):
            self.pose(None if ahead is None else WALL + self.now + ahead, **given)
            self.now += PERIOD

    def poses_of(self, frames: int, **given) -> int:
        """How many of so many frames are flown on."""
        before = self.pipeline.latest.count
        self.fly(frames, **given)
        return self.pipeline.latest.count - before


@pytest.fixture
def flight() -> Iterator[Flight]:
    made = Flight()
    made.fly(100)
    assert made.read().quality is PoseQuality.MEASURED and not made.counts
    yield made
    made.close()


@pytest.mark.parametrize("ahead", [3600.0, 30.0, 1.0, 0.5, -0.5, -1.0, -30.0, -3600.0, -WALL + 5.0])
@pytest.mark.parametrize("strays", [1, 2])
def test_stamps_of_another_time_cost_themselves_alone(flight: Flight, ahead: float, strays: int) -> None:
    flight.fly(strays, ahead=ahead)
    if strays == 1 or ahead < 0.0:
        assert flight.poses_of(100) == 100
    else:
        assert flight.poses_of(100) >= 85
    assert flight.read().quality is PoseQuality.MEASURED
    assert flight.counts & Counter({MocapFault.NUMBERING: 1, MocapFault.REORDERED: 1, MocapFault.DUPLICATED: 1})


@pytest.mark.parametrize("ahead", [3600.0, 2.0, 0.3, 0.05, -0.05, -0.3, -1.0, -2.0, -3.0, -3600.0, -WALL])
def test_a_publishers_clock_that_is_set_is_followed_and_told(flight: Flight, ahead: float) -> None:
    poses = flight.poses_of(300, ahead=ahead)
    assert poses >= 280
    assert flight.read().quality is PoseQuality.MEASURED
    assert flight.read().age < LATE + PERIOD + 0.005
    assert flight.counts[MocapFault.RESTARTED] == 1


def test_a_clock_that_is_set_again_and_again_is_followed(flight: Flight) -> None:
    for k in range(8):
        assert flight.poses_of(100, ahead=-5.0 * (k + 1)) >= 80


def test_a_stamp_that_stands_still_is_told(flight: Flight) -> None:
    stamp = WALL + flight.now
    for _ in range(50):
        flight.pose(stamp)
        flight.now += PERIOD
    assert flight.read().quality is PoseQuality.LOST
    assert flight.counts[MocapFault.DUPLICATED] >= 45 and not flight.counts[MocapFault.SILENT]


def test_a_second_publisher_is_not_flown_on_and_told(flight: Flight) -> None:
    before = flight.pipeline.latest.count
    for _ in range(200):
        flight.fly(1)
        flight.now -= 0.5 * PERIOD
        flight.pose(WALL + flight.now, SECOND, aside=3.0)
        flight.now += 0.5 * PERIOD
    assert flight.pipeline.latest.count - before == 200
    assert flight.counts[MocapFault.FOREIGN] >= 199 and flight.relay.refused == 200
    assert flight.counts.keys() == {MocapFault.FOREIGN}
    assert [event.fault for event in flight.relay.events()] == [MocapFault.FOREIGN]


def test_another_publisher_takes_over_after_a_silence(flight: Flight) -> None:
    flight.fly(30, publisher=SECOND)
    assert flight.counts[MocapFault.SILENT] == 1
    assert flight.poses_of(100, publisher=SECOND) >= 95
    flight.fly(10)
    assert flight.relay.refused >= 19 + 10


def test_a_publisher_that_was_started_again_with_another_clock_takes_over(flight: Flight) -> None:
    flight.now += 1.0
    assert flight.poses_of(100, publisher=SECOND, ahead=-1e5) >= 80
    assert flight.relay.refused == 0


@pytest.mark.parametrize("bad", [{"aside": math.nan}, {"aside": math.inf}, {"quaternion": (0.0,) * 4},
                                 {"quaternion": (math.nan, 0.0, 0.0, 0.0)}])  # fmt: skip
def test_what_is_no_pose_is_corrupt(flight: Flight, bad: dict) -> None:
    flight.fly(3, **bad)
    assert flight.counts[MocapFault.CORRUPT] == 3 == flight.relay.refused
    assert flight.poses_of(50) == 50


def test_poses_without_stamps_are_numbered_by_their_arrival() -> None:
    flight = Flight()
    flight.fly(200, ahead=None)
    assert flight.read().quality is PoseQuality.MEASURED and not flight.counts
    flight.close()
