"""A held tip that goes round the hinge as it should, and one that does not, since cameras or joint angles drift."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.hardware.safety.consistency import HeldTip
from doorman.model import Model
from doorman.scenario import Scenario

MODEL = Model(Scenario.load("paper"))
LIMIT = MODEL.scenario.safety.misfit
LOOK = 0.02
"""Between two looks of the supervisor [s]."""
START, GOAL, SWING = math.pi / 2, math.radians(20.0), 5.0
"""Of the leaf [rad], and the time in between [s]."""


def leaf(time: float) -> float:
    """Angle of a leaf that swings from closed to the goal, and stays there [rad]."""
    share = min(time / SWING, 1.0)
    return START + (GOAL - START) * share * share * (3.0 - 2.0 * share)


def told_after(
    hinge: tuple[float, float] = (0.0, 0.0),
    drift: tuple[float, float, float] = (0.0, 0.0, 0.0),
    joint: float = 0.0,
    since: float = 1.0,
    noise: float = 0.002,
    duration: float = 12.0,
) -> float:
    """When a held tip was told not to fit, from when on something drifts [m/s] or joint 3 lies [rad/s]; ∞ if it never was [s]."""
    random, held, arm = np.random.default_rng(3), HeldTip(MODEL), MODEL.goal_arm
    coupling = MODEL.coupling
    for index in range(round(duration / LOOK)):
        time = LOOK * index
        angle = leaf(time)
        attitude = np.array([0.02 * math.sin(time), 0.03 * math.sin(1.7 * time), angle - START])
        position = coupling.vehicle_position(attitude, angle, arm) + [*hinge, 0.0]
        late = max(time - since, 0.0)
        seen = position + late * np.array(drift) + noise * random.standard_normal(3)
        angles = arm + late * joint * (np.arange(MODEL.n_arm) == 2)
        held.take(seen, attitude, angles, 100.0 + time)
        if held.misfit > LIMIT:
            return time - since
    return math.inf


@pytest.mark.parametrize("hinge", [(0.0, 0.0), (0.035, 0.0), (0.0, -0.035), (-0.025, 0.025)])
def test_a_tip_that_goes_round_fits_wherever_the_hinge_may_be(hinge):
    assert told_after(hinge) == math.inf


@pytest.mark.parametrize(
    ("drift", "since", "within"),
    [
        ((0.0, 0.05, 0.0), 1.0, 2.5),
        ((0.05, 0.0, 0.0), 1.0, 2.5),
        ((0.0, 0.02, 0.0), 1.0, 7.0),
        ((0.02, 0.0, 0.0), 1.0, 5.0),
        ((0.05, 0.0, 0.0), 6.0, 1.0),
        ((0.01, 0.0, 0.0), 6.0, 3.0),
        ((0.0, 0.0, 0.01), 1.0, 3.0),
    ],
)
def test_a_drift_of_the_cameras_is_told(drift, since, within):
    assert 0.0 < told_after(drift=drift, since=since) < within


def test_a_joint_angle_that_creeps_is_told():
    assert 0.0 < told_after(joint=math.radians(2.0)) < 3.0


def test_a_drift_along_the_circle_looks_like_a_leaf_that_swings():
    """As the module says: it has no other sign while the leaf stands."""
    along = 0.02 * MODEL.door.normal(GOAL)
    assert told_after(drift=tuple(along), since=6.0, duration=8.0) == math.inf


def test_a_tip_that_was_let_go_may_grip_elsewhere():
    held, arm, still = HeldTip(MODEL), MODEL.goal_arm, np.zeros(3)
    place = MODEL.coupling.vehicle_position(still, START, arm)
    for index in range(50):
        held.take(place, still, arm, LOOK * index)
        assert held.misfit < LIMIT
    held.let_go()
    for index in range(50, 100):
        held.take(place + [0.0, 0.2, 0.1], still, arm, LOOK * index)
        assert held.misfit < LIMIT


def test_only_a_gripper_on_a_plumb_hinge_ties_a_tip_to_a_circle():
    assert HeldTip.of(MODEL) is not None
    for other in ("push", "drawer"):
        assert HeldTip.of(Model(Scenario.load(other))) is None
