"""How old poses may be."""

from __future__ import annotations

import math

import pytest

from doorman.control.estimation.pose_age import LATEST, crossover, oldest_pose
from doorman.feasibility.inputs.setup import setup_findings
from doorman.model import Model
from doorman.scenario import ControlSection, Scenario


@pytest.mark.parametrize(("stiff", "damped"), [(4.0, 3.5), (9.0, 5.0), (1.0, 2.0), (16.0, 1.0)])
def test_the_position_loop_crosses_over_where_its_gain_is_one(stiff, damped):
    control = ControlSection(position_gain=(stiff, stiff, 6.0), velocity_gain=(damped, damped, 4.5))
    rate = crossover(control)
    assert abs(complex(stiff, damped * rate)) / rate**2 == pytest.approx(1.0)
    assert LATEST / oldest_pose(control) > 2.0 * rate, "the observer is faster"
    slower = ControlSection(position_gain=(0.5 * stiff, 0.5 * stiff, 6.0), velocity_gain=(damped, damped, 4.5))
    assert oldest_pose(slower) > oldest_pose(control)


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
