"""Where the vehicle is: by the autopilot, by the cameras, or by who spoke last."""

from __future__ import annotations

import time
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from doorman.hardware.mocap import PoseQuality
from doorman.hardware.mocap.sample import PoseSample, measured
from doorman.hardware.pixhawk import SampleStatus, VehicleSample
from doorman.hardware.vehicle import VehicleLinks


def state(status: SampleStatus, age: float) -> VehicleSample:
    now = time.monotonic() - age
    return VehicleSample(
        status=status, attitude_time=now, position_time=now, position=np.array([1.0, 0.0, 0.0]), velocity=np.zeros(3),
        attitude=np.array([0.0, 0.0, 0.1]), quaternion=np.array([1.0, 0.0, 0.0, 0.0]), body_rates=np.zeros(3),
    )  # fmt: skip


def pose(quality: PoseQuality, age: float) -> PoseSample:
    still = (0.0, 0.0, 0.0)
    sample = measured(time.monotonic() - age, (2.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), still, still, 5, 9)
    return replace(sample, quality=quality)


def links(heard: VehicleSample, seen: PoseSample | None) -> Any:
    asked: list[Any] = []
    autopilot = SimpleNamespace(state=lambda: heard, hold=lambda at, latch: asked.append(at), asked=asked)
    made = object.__new__(VehicleLinks)
    made.__dict__.update(autopilot=autopilot, mocap=None if seen is None else SimpleNamespace(read=lambda: seen))
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
