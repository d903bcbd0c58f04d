"""How old poses may be, and how they are carried on to now."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from doorman.control.estimation.pose_age import crossover, oldest_pose
from doorman.control.estimation.present import present, present_attitude
from doorman.control.observers.vehicle_observer import LATEST
from doorman.feasibility.inputs.setup import setup_findings
from doorman.kinematics.rotations import attitude_from_rotation, rotation_body_to_world, skew
from doorman.model import Model
from doorman.scenario import ControlSection, Scenario
from doorman.signals import Measurement


@pytest.mark.parametrize(("stiff", "damped"), [(4.0, 3.5), (9.0, 5.0), (1.0, 2.0), (16.0, 1.0)])
def test_the_position_loop_crosses_over_where_its_gain_is_one(stiff, damped):
    control = ControlSection(position_gain=(stiff, stiff, 6.0), velocity_gain=(damped, damped, 4.5))
    rate = crossover(control)
    assert abs(complex(stiff, damped * rate)) / rate**2 == pytest.approx(1.0)
    assert LATEST / oldest_pose(control) > 2.0 * rate, "the observer is faster"
    slower = ControlSection(position_gain=(0.5 * stiff, 0.5 * stiff, 6.0), velocity_gain=(damped, damped, 4.5))
    assert oldest_pose(slower) > oldest_pose(control)


def measured(time: float, seen: float, attitude, body_rates) -> Measurement:
    return Measurement(
        time, np.array([1.0, 2.0, 3.0]), np.zeros(3), np.array(attitude), np.array(body_rates), np.zeros(2), np.zeros(2), seen
    )  # fmt: skip


def test_an_attitude_is_carried_on_by_the_gyroscope():
    attitude, rates, age = np.array([0.1, -0.2, 3.1]), np.array([0.4, 0.3, -0.5]), 1e-3
    turned = rotation_body_to_world(attitude) @ (np.eye(3) + age * skew(rates))
    now = present_attitude(measured(5.0 + age, 5.0, attitude, rates))
    assert now == pytest.approx(attitude_from_rotation(turned), abs=1e-6)
    fresh = measured(5.0, 5.0, attitude, rates)
    assert present(fresh, np.ones(3)) is fresh, "nothing is made of what is new"


def test_a_position_is_carried_on_by_the_velocity_that_is_known():
    now = present(measured(5.04, 5.0, np.zeros(3), [0.0, 0.0, 1.0]), np.array([0.5, 0.0, -0.25]))
    assert now.position == pytest.approx([1.02, 2.0, 2.99]) and now.attitude == pytest.approx([0.0, 0.0, 0.04])
    assert now.pose_time == now.time == 5.04


def test_an_arm_that_is_late_is_carried_on_by_its_rates():
    late = replace(measured(5.04, 5.04, np.zeros(3), np.zeros(3)), arm_rates=np.array([0.5, -1.0]), arm_time=5.02)
    assert present(late, np.zeros(3)).arm_angles == pytest.approx([0.01, -0.02])
    assert present(replace(late, arm_time=None), np.zeros(3)).arm_angles.tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    ("changes", "severity"),
    [
        ({}, "ok"),
        ({"latency": 0.04, "rate": 100.0}, "ok"),
        ({"latency": 0.05, "rate": 100.0}, "warning"),
        ({"latency": 0.06, "rate": 100.0}, "error"),
        ({"latency": 0.03, "rate": 40.0, "jitter": 0.02}, "error"),
    ],
)
def test_the_check_refuses_poses_that_are_too_old_for_the_gains(changes, severity):
    given = {f"simulation.sensors.{name}": value for name, value in changes.items()}
    found = {one.name: one for one in setup_findings(Model(Scenario.load("push", given)))}["age of poses"]
    assert found.severity == severity and math.isfinite(found.limit), found
    slow = {**given, "control.position_gain": (1.0, 1.0, 6.0), "control.velocity_gain": (2.0, 2.0, 4.5)}
    found = {one.name: one for one in setup_findings(Model(Scenario.load("push", slow)))}["age of poses"]
    assert found.severity == "ok", "smaller gains need less"
