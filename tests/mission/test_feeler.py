"""A tip that feels its way, on a vehicle that is a point mass before a wall, as the estimate at the leaf sees it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from doorman.control.at_the_leaf import SPEED_GAIN
from doorman.control.estimation.estimator import Estimator, Tie
from doorman.gravity import GRAVITY
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.mission.feeler import Feeler
from doorman.model import Model
from doorman.signals import Measurement

TICK = 0.005
STIFFNESS, DAMPING = 2000.0, 60.0
NOISE = 1e-3
"""Of the poses [m]."""


def felt(
    model: Model, wall: float, gust: Any = lambda time: 0.0, seconds: float = 6.0
) -> tuple[float | None, float, float]:
    """How far away the tip was stopped, when, and with which force it presses then; the wind is there for 2 s before."""
    rng, mass, none, into = np.random.default_rng(3), model.vehicle.mass, np.zeros(3), model.door.into
    estimator = Estimator(model)
    feeler = Feeler(model, none, 0.0, into, 0.08, none)
    attitude = np.array([0.0, 0.0, model.start_yaw])
    back = rotation_body_to_world(attitude).T
    tip = model.vehicle.tip_position(model.start_arm)
    start = model.door.hinge_position - 2.0 * into - tip
    at, moves, push, press = 0.0, 0.0, 0.0, 0.0
    for k in range(round((2.0 + seconds) / TICK)):
        now = TICK * k - 2.0
        seen = start + at * into + rng.normal(0.0, NOISE, 3)
        measured = Measurement(now, seen, none, attitude, none, model.start_arm, np.zeros(model.n_arm), now)
        estimator.feel(into if now >= 0.0 else None)
        known = estimator.update(measured, Tie.FREE, False, TICK)
        if now >= 0.0:
            setpoint = feeler.step(known, known.position + tip)
            assert setpoint.push is not None
            if (met := feeler.met(now)) is not None:
                return float(into @ (met - start - tip)), now, press
            push = setpoint.push
        else:
            push = -gust(now)
        deep = max(at - wall, 0.0)
        press = max(STIFFNESS * deep + DAMPING * moves, 0.0) if deep > 0.0 else 0.0
        estimator.note_force(back @ (push * into + np.array([0.0, 0.0, mass * GRAVITY])))
        moves += TICK / mass * (push + gust(now) - press)
        at += TICK * moves
    return None, seconds, press


@pytest.fixture(scope="module")
def model() -> Model:
    return Model("push")


@pytest.mark.parametrize("wall", [0.05, 0.15])
def test_a_wall_is_found_where_it_stands(model: Model, wall: float) -> None:
    met, when, pressed = felt(model, wall)
    assert met == pytest.approx(wall, abs=0.003)
    assert when < wall / 0.08 + 2.0 and pressed < 3.0, "its own push on the wall is no wind"


def test_nothing_is_found_where_there_is_nothing(model: Model) -> None:
    assert felt(model, 10.0)[0] is None


@pytest.mark.parametrize(
    ("begins", "force", "wall"),
    [(1.0, -1.0, 0.25), (1.0, -2.0, 0.25), (1.0, 1.0, 0.25), (-2.0, -1.5, 0.15), (-2.0, 1.5, 0.15)],
)
def test_wind_that_is_steady_or_stops_the_tip_or_blows_it_back_is_no_wall(
    model: Model, begins: float, force: float, wall: float
) -> None:
    met, _, _ = felt(model, wall, lambda time: force if time >= begins else 0.0, seconds=10.0)
    assert met == pytest.approx(wall, abs=0.003)


def test_a_gust_beside_the_direction_is_held_against(model: Model) -> None:
    steady, gust, into = np.array([0.4, 0.3, 0.2]), np.array([0.5, 0.9, -0.6]), np.array([1.0, 0.0, 0.0])
    feeler = Feeler(model, np.zeros(3), 0.0, into, 0.08, steady)
    estimate: Any = SimpleNamespace(
        time=0.0, position=np.zeros(3), velocity=np.zeros(3), attitude_rates=np.zeros(3), wind=steady + gust,
        arm_angles=model.start_arm, stopped=False,
    )  # fmt: skip
    setpoint = feeler.step(estimate, np.zeros(3))
    np.testing.assert_allclose(model.vehicle.mass * setpoint.acceleration, [0.0, -0.9, 0.0], atol=1e-12)


def test_a_vehicle_that_turns_about_a_stopped_tip_pushes_on(model: Model) -> None:
    """Its body moves on, and its tip does not."""
    into, tip, turns = np.array([0.0, -1.0, 0.0]), np.array([0.6, 0.0, 0.0]), np.array([0.0, 0.0, 0.07])
    feeler = Feeler(model, np.zeros(3), 0.0, into, 0.04, np.zeros(3))
    estimate: Any = SimpleNamespace(
        time=0.0, position=np.zeros(3), velocity=-np.cross(turns, tip), attitude_rates=turns, wind=np.zeros(3),
        arm_angles=model.start_arm, stopped=False,
    )  # fmt: skip
    turning, push = feeler.step(estimate, tip), SPEED_GAIN * model.scale.damping * 0.04
    assert turning.push == pytest.approx(push)
    estimate.attitude_rates = np.zeros(3)
    assert feeler.step(estimate, tip).push == pytest.approx(push - SPEED_GAIN * model.scale.damping * 0.042)
