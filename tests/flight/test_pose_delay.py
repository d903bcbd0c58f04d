"""Delay of poses, measured against an autopilot that feels the same motion."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from doorman.flight.ground.judgements import Verdict, judge_age
from doorman.flight.hover import PoseDelay
from doorman.hardware.mocap.sample import measured
from doorman.hardware.pixhawk import VehicleSample
from doorman.kinematics.rotations import quaternion_of


def told(delay: float, size: float = 0.06, noise: float = 0.0, duration: float = 2.7, stranger: bool = False) -> float:
    """Of cameras that stamp poses too new by a delay, read 50 times a second."""
    random, poses = np.random.default_rng(2), PoseDelay()

    def angles(time: float, phase: float = 0.0) -> np.ndarray:
        return np.array([size * math.sin(5.2 * time + phase), 0.2 * size * math.sin(9.0 * time), 0.3])

    for index in range(round(50 * duration)):
        now = 7.0 + 0.02 * index
        taken = 0.01 * math.floor(100.0 * (now - 0.015 - max(delay, 0.0)))
        seen = angles(taken, 1.6 if stranger else 0.0) + noise * random.standard_normal(3)
        pose = measured(taken + delay, (0.0, 0.0, 1.0), quaternion_of(seen), (0.0,) * 3, (0.0,) * 3,
                        index, 1)  # fmt: skip
        felt = now - 0.007
        poses.note(pose, replace(VehicleSample(), attitude_time=felt, attitude=angles(felt)))
    return poses.delay


@pytest.mark.parametrize("delay", [0.0, 0.012, 0.03, 0.07, -0.01])
def test_the_delay_of_stamps_is_found(delay):
    assert told(delay) == pytest.approx(delay, abs=0.003)
    assert told(delay, noise=0.0035) == pytest.approx(delay, abs=0.008)


def test_nothing_is_told_where_nothing_can_be():
    assert math.isnan(told(0.02, size=0.002)), "it stands"
    assert math.isnan(told(0.02, duration=0.5)), "too short"
    assert math.isnan(told(0.0, stranger=True, size=0.06, noise=0.2)), "strangers"
    assert math.isnan(PoseDelay().delay)


@pytest.mark.parametrize(
    ("latency", "rate", "verdict"),
    [(0.008, 100.0, Verdict.GOOD), (0.045, 100.0, Verdict.WARNING), (0.06, 100.0, Verdict.BAD), (0.03, 25.0, Verdict.BAD),
     (0.01, 0.0, Verdict.BAD), (math.nan, 100.0, Verdict.BAD)],
)  # fmt: skip
def test_poses_that_are_too_old_ground_the_vehicle(latency, rate, verdict):
    row = judge_age(latency, rate, 0.063)
    assert row.verdict is verdict and bool(row.advice) is (verdict is not Verdict.GOOD)
