"""Friction, closer and damping of a hinge, from what its leaf resists with on the way."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.estimation.leaf.hinge_fit import HingeFit
from doorman.model import Model


@pytest.fixture(scope="module", params=["push", "push_left"])
def model(request: pytest.FixtureRequest) -> Model:
    return Model(request.param)


def swung(model: Model, friction: float, stiffness: float, damping: float, noise: float = 0.1) -> HingeFit:
    """A leaf that opens by 70°, first slowly."""
    fit, rng, sense = HingeFit(model), np.random.default_rng(2), model.travel.sense
    angle, rate = model.start_angle, 0.0
    for k in range(6000):
        rate = sense * min(0.05 + 2e-4 * k, 0.35)
        angle += 1e-3 * rate
        closer = stiffness * abs(angle - model.door.rest_angle)
        resists = friction + closer + damping * abs(rate) + noise * rng.normal()
        fit.learn(1e-3 * k, angle, rate, resists, noise, 0.0)
    return fit


@pytest.mark.parametrize(("friction", "stiffness"), [(1.5, 0.0), (0.4, 1.5), (1.0, 0.8)])
def test_what_holds_the_leaf_is_told_from_what_drives_it_back(model: Model, friction: float, stiffness: float) -> None:
    fit, angle = swung(model, friction, stiffness, 0.5), model.goal_angle
    turned = abs(angle - model.door.rest_angle)
    found = fit.found(angle, 5.0, 0.1)
    assert abs(found.friction - friction) < 2.0 * found.friction_deviation
    assert abs(found.stiffness - stiffness) < 2.0 * found.stiffness_deviation
    share = friction / (friction + stiffness * turned)
    assert fit.friction_share(angle) == pytest.approx(share, abs=0.2)
    before = HingeFit(model).found(angle, 5.0, 0.1)
    assert found.torque_deviation < before.torque_deviation


def test_a_leaf_that_stands_teaches_nothing(model: Model) -> None:
    fit = HingeFit(model)
    before = fit.found(1.0, 5.0, 0.1)
    for k in range(100):
        fit.learn(float(k), 1.0, 0.0, 9.0, 0.1, 0.0)
    assert fit.found(1.0, 5.0, 0.1) == before


def test_a_leaf_that_stood_by_itself_has_the_friction_for_it(model: Model) -> None:
    fit = swung(model, 0.3, 1.5, 0.0)
    angle = model.goal_angle
    assert fit.friction_share(angle) < 0.4
    fit.stays(angle)
    assert fit.friction_share(angle) == pytest.approx(0.5, abs=0.01), "as much as the closer makes"


def test_a_looks_worth_is_less_in_wind(model: Model) -> None:
    deviations = []
    for wind in (0.0, 2.0):
        fit = HingeFit(model)
        for k in range(20):
            fit.learn(0.5 * k, model.goal_angle, 0.2 * math.copysign(1.0, model.travel.sense), 1.0, 0.1, wind)
        deviations.append(fit.found(model.goal_angle, 5.0, 0.1).friction_deviation)
    assert deviations[0] < deviations[1]
