"""Where the vehicle is: by the autopilot, by the cameras, or by who spoke last."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from doorman.hardware.mocap import MocapConfig, PoseQuality
from doorman.hardware.mocap.sample import PoseSample, measured
from doorman.hardware.pixhawk import SampleStatus, VehicleSample
from doorman.hardware.vehicle import VehicleBackend, VehicleLinks
from doorman.hardware.vehicle.waiting import tilt_between
from doorman.kinematics.rotations import quaternion_of


def state(status: SampleStatus, age: float) -> VehicleSample:
    now = time.monotonic() - age
    return VehicleSample(
        status=status, attitude_time=now, position_time=now, position=np.array([1.0, 0.0, 0.0]), velocity=np.zeros(3),
        attitude=np.array([0.0, 0.0, 0.1]), quaternion=np.array([1.0, 0.0, 0.0, 0.0]), body_rates=np.zeros(3),
    )  # fmt: skip


def pose(quality: PoseQuality, age: float) -> PoseSample:
    still = (0.0, 0.0, 0.0)
    sample = measured(time.monotonic() - age, (2.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.3, 0.0, 0.0), still, 5, 9)
    return replace(sample, quality=quality)


def links(heard: VehicleSample, seen: PoseSample | None, doubted: bool = False) -> Any:
    asked: list[Any] = []
    autopilot = SimpleNamespace(state=lambda: heard, hold=lambda at, latch: asked.append(at), asked=asked)
    made = object.__new__(VehicleLinks)
    mocap = None if seen is None else SimpleNamespace(read=lambda: seen)
    made.__dict__.update(autopilot=autopilot, mocap=mocap, doubt=SimpleNamespace(holds=doubted))
    return made


FRESH, STALE = SampleStatus.FRESH, SampleStatus.STALE


@pytest.mark.parametrize(
    ("heard", "seen", "x", "known"),
    [
        (state(FRESH, 0.0), pose(PoseQuality.MEASURED, 0.0), 1.0, True),
        (state(FRESH, 0.0), None, 1.0, True),
        (state(STALE, 0.5), pose(PoseQuality.MEASURED, 0.0), 2.0, True),
        (state(STALE, 0.5), pose(PoseQuality.PREDICTED, 0.1), 2.0, True),
        (state(STALE, 5.0), pose(PoseQuality.LOST, 0.6), 2.0, False),
        (state(STALE, 0.5), pose(PoseQuality.LOST, 5.0), 1.0, False),
        (state(STALE, 0.5), None, 1.0, False),
    ],
)
def test_whereabouts(heard, seen, x, known):
    where = links(heard, seen).whereabouts()
    assert (where.position[0], where.known) == (x, known)


@pytest.mark.parametrize(("age", "holds"), [(0.6, True), (1.5, False)])
def test_a_hold_needs_a_place_of_the_last_second(age, holds):
    vehicle = links(state(STALE, 5.0), pose(PoseQuality.LOST, age))
    vehicle.hold(latch=True)
    place = vehicle.autopilot.asked[0]
    assert (place is not None) is holds
    assert not holds or place.position[0] == 2.0


def test_no_hold_at_a_pose_that_is_doubted():
    """It is new, and wrong: another body was taken for the vehicle."""
    vehicle = links(state(STALE, 0.4), pose(PoseQuality.LOST, 0.0), doubted=True)
    vehicle.hold(latch=True)
    assert vehicle.autopilot.asked[0].position[0] == 1.0


def test_a_pose_that_is_late_but_usable_is_a_new_one_every_time():
    """What is flown on is the newest measurement, not the last that was fresh."""
    backend = object.__new__(VehicleBackend)
    config = MocapConfig("vehicle")
    for age in (0.0, 0.06, 0.06):
        measurement = pose(PoseQuality.MEASURED, age)
        read = measurement.at(time.monotonic(), config.stale_after, config.prediction_limit)
        backend.links = links(state(FRESH, 0.0), read)
        newest = backend._newest_pose()
        assert newest is not None and newest.time == measurement.time
        assert newest.position.tolist() == [2.0, 0.0, 0.0]


def attitude(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """Quaternion of Euler angles [deg]."""
    return np.array(quaternion_of(np.radians([roll, pitch, yaw])))


@pytest.mark.parametrize("yaw", [0.0, 17.0, 180.0])
def test_a_heading_is_no_tilt(yaw: float) -> None:
    assert tilt_between(attitude(0.0, 0.0, 0.0), attitude(0.0, 0.0, yaw)) == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize(("roll", "pitch"), [(4.0, 0.0), (0.0, -4.0)])
def test_a_tilted_object_is_seen_at_any_heading(roll: float, pitch: float) -> None:
    level, tilted = attitude(0.0, 0.0, 40.0), attitude(roll, pitch, 40.0)
    assert math.degrees(tilt_between(level, tilted)) == pytest.approx(4.0, abs=1e-6)
    assert math.degrees(tilt_between(-tilted, level)) == pytest.approx(4.0, abs=1e-6)
