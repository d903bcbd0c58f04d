"""An autopilot that steers elsewhere than it was told, while the gripper holds on to the door."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from doorman.hardware.pixhawk import VehicleSample
from doorman.hardware.safety.observer import Observer

TOLD = np.array([0.1, -0.05, 2.0])


def seen(target: np.ndarray, age: float = 0.05, holding: bool = True, setpoints: str = "attitude", told=TOLD) -> float:
    links = SimpleNamespace(holding=holding, config=SimpleNamespace(pixhawk=SimpleNamespace(setpoints=setpoints)))
    observer = Observer.__new__(Observer)
    observer._backend = SimpleNamespace(links=links, commanding=True, attitude=told)
    return observer._disobedience(VehicleSample(attitude_target=target, thrust_target_time=10.0 - age), 10.0)


@pytest.mark.parametrize("turn", [[0.0, 0.0, 0.0], [0.25, 0.0, 0.0], [0.0, -0.3, 0.0], [0.0, 0.0, 0.4]])
def test_angle_between_what_was_told_and_what_is_steered_by(turn):
    assert seen(TOLD + turn) == pytest.approx(float(np.abs(turn).max()), abs=0.02)


def test_a_turn_of_the_yaw_by_a_whole_circle_is_none():
    assert seen(TOLD + [0.0, 0.0, 2.0 * math.pi]) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    "why", [{"holding": False}, {"setpoints": "position"}, {"age": 1.0}, {"told": np.full(3, math.nan)}]
)
def test_nothing_is_said_without_a_grip_a_command_or_a_fresh_target(why):
    assert math.isnan(seen(TOLD + [0.5, 0.0, 0.0], **why))
    assert math.isnan(seen(np.full(3, math.nan)))
