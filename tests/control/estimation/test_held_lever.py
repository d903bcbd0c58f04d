"""A step that begins with a lever in the gripper: what the step before has left is known, and the lever may turn on."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.control.estimation.estimator import Estimate, Estimator, Tie
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.signals import Measurement
from doorman.stages import stages

TICK, NOISE = 0.004, 3e-4
HELD = np.array([0.0, 0.0, -3.0])
"""With which the tip holds the lever down [N]."""


@pytest.fixture(scope="module")
def model() -> Model:
    return stages(Scenario.load("lever_pull"))[-1]


def flown(model: Model, came_along: float, sinks: float = 0.0, seconds: float = 1.0) -> Estimate:
    """Level at rest, with a leaf that has come along in the step before, and a lever that turns on meanwhile by a way [m]."""
    estimator, rng = Estimator(model), np.random.default_rng(3)
    estimator.go_on(HELD, {"wind": (np.zeros(3), np.full(3, 0.1)), "lift": (np.zeros(1), np.full(1, 0.01))})
    estimator.note_force(np.array([0.0, 0.0, model.vehicle.weight + HELD[2]]))
    attitude = np.array([0.0, 0.0, model.start_yaw])
    place = model.coupling.vehicle_position(attitude, model.start_angle + came_along, model.start_arm)
    count, known = round(seconds / TICK), None
    for k in range(count):
        share = min(k / (0.2 * count), 1.0)
        seen = place - [0.0, 0.0, share * sinks] + NOISE * rng.normal(size=3)
        still = np.zeros(model.n_arm)
        measured = Measurement(k * TICK, seen, np.zeros(3), attitude, np.zeros(3), model.start_arm, still, k * TICK)
        known = estimator.update(measured, Tie.GRIPPED, True, TICK)
    assert known is not None
    return known


@pytest.mark.parametrize("came_along", [0.0, 0.035])
def test_a_leaf_that_came_along_is_where_the_tip_holds_it(model: Model, came_along: float) -> None:
    known = flown(model, came_along)
    assert known.touching
    assert abs(known.door_angle - model.start_angle - came_along) < math.radians(0.3)


def test_the_force_that_holds_a_lever_is_no_lift_and_no_wind(model: Model) -> None:
    known = flown(model, 0.0, seconds=3.0)
    assert known.tip_force[2] == pytest.approx(HELD[2], abs=0.5)
    assert abs(known.lift) < 0.01 and abs(known.wind[2]) < 0.3


def test_a_lever_that_turns_on_has_not_slipped_out_of_the_gripper(model: Model) -> None:
    assert flown(model, 0.0, sinks=0.01).touching
