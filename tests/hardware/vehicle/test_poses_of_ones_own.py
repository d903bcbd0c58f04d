"""Any `PoseSource` in place of cameras: links take it, and what flies by them asks it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.exceptions import BackendError
from doorman.hardware.mocap import PoseSample, PoseSource
from doorman.hardware.mocap.sample import measured, nothing_yet
from doorman.hardware.vehicle import VehicleLinks, vehicle_config
from doorman.model import Model
from doorman.scenario import Scenario


class Clock:
    """Goes on while somebody sleeps."""

    def __init__(self) -> None:
        self.time = 10.0

    def now(self) -> float:
        return self.time

    def sleep(self, duration: float) -> None:
        self.time += duration


class Odometry:
    """A source with three methods, 50 poses a second."""

    def __init__(self, clock: Clock, sees: bool = True) -> None:
        self.clock, self.sees, self.opened, self.stopped = clock, sees, False, 0

    def open(self) -> None:
        self.opened = True

    def read(self) -> PoseSample:
        now = self.clock.now()
        if not self.sees:
            return nothing_yet().at(now, 0.04, 0.2)
        number = math.floor((now - 10.0) * 50.0)
        at = 10.0 + number / 50.0
        pose = measured(
            at, (0.1 * at, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.0, 0.0), number, number + 1
        )
        return pose.at(now, 0.04, 0.2)

    def stop(self) -> None:
        self.stopped += 1


def links_of(source: Odometry, clock: Clock) -> VehicleLinks:
    config = vehicle_config(
        Model(Scenario.load("push")), "udp:14540", "/dev/null", "udp:51001", links={"mocap.rate": 50.0}
    )
    links = VehicleLinks(config, poses=source)
    assert isinstance(source, PoseSource)
    links.mocap._clock = clock
    return links


def test_links_take_poses_of_any_source():
    clock = Clock()
    source = Odometry(clock)
    mocap = links_of(source, clock).mocap
    mocap.open()
    sample = mocap.read()
    assert source.opened and sample.fresh
    for _ in range(100):
        before, sample = sample, mocap.wait(sample, 0.1)
        assert sample.count == before.count + 1
    np.testing.assert_allclose(sample.position, (0.1 * sample.time, 0.0, 1.0))
    assert mocap.statistics.frame_rate == pytest.approx(50.0, rel=0.1) and mocap.events() == []
    source.sees = False
    with pytest.raises(BackendError, match="no new pose"):
        mocap.wait(sample, 0.1)
    mocap.stop()
    mocap.stop()
    assert source.stopped == 2


def test_a_source_without_a_pose_is_told():
    clock = Clock()
    source = Odometry(clock, sees=False)
    with pytest.raises(BackendError, match="brings no pose"):
        links_of(source, clock).mocap.open()
    assert source.stopped == 1
