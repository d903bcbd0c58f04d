"""A tip that feels its way, on a vehicle that is a point mass before a wall."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from doorman.mission.feeler import Feeler
from doorman.model import Model

TICK, INTO = 0.005, np.array([1.0, 0.0, 0.0])
STIFFNESS, DAMPING = 2000.0, 60.0


def felt(
    model: Model, wall: float, gust: Any = lambda time: 0.0, seconds: float = 6.0
) -> tuple[np.ndarray | None, float, float]:
    """Where the tip was stopped, when, and with which force it presses then; the wind is known 0.3 s later."""
    rng, mass = np.random.default_rng(3), model.vehicle.mass
    feeler = Feeler(model, np.zeros(3), 0.0, INTO, 0.08, np.zeros(3))
    at, speed, wind, pressed = 0.0, 0.0, 0.0, 0.0
    for k in range(round(seconds / TICK)):
        now, deep = TICK * k, max(at - wall, 0.0)
        press = max(STIFFNESS * deep + DAMPING * speed, 0.0) if deep > 0.0 else 0.0
        pressed += TICK / 0.1 * (press - pressed)
        wind += TICK / 0.3 * (gust(now) - press - wind)  # the wall passes for wind, too
        estimate: Any = SimpleNamespace(time=now, velocity=speed * INTO, wind=wind * INTO, arm_angles=model.start_arm)
        setpoint = feeler.step(estimate, at * INTO + rng.normal(0.0, 0.0015, 3), TICK)
        if (met := feeler.met(now)) is not None:
            return met, now, pressed
        assert setpoint.push is not None
        speed += TICK / mass * (setpoint.push + gust(now) - press)
        at += TICK * speed
    return None, seconds, pressed


@pytest.fixture(scope="module")
def model() -> Model:
    return Model("push")


@pytest.mark.parametrize("wall", [0.05, 0.1, 0.2])
def test_a_wall_is_found_where_it_stands(model: Model, wall: float) -> None:
    met, when, pressed = felt(model, wall)
    assert met is not None and met[0] == pytest.approx(wall, abs=0.003)
    assert when < wall / 0.08 + 2.0 and pressed < 3.0, "its own push on the wall is no wind"


def test_nothing_is_found_where_there_is_nothing(model: Model) -> None:
    assert felt(model, 10.0)[0] is None


@pytest.mark.parametrize("force", [-0.6, -1.0, -2.0, 1.0])
def test_a_gust_that_stops_the_tip_or_blows_it_back_is_no_wall(model: Model, force: float) -> None:
    met, _, _ = felt(model, 0.25, lambda time: force if time > 1.0 else 0.0, seconds=10.0)
    assert met is not None and met[0] == pytest.approx(0.25, abs=0.003)


def test_steady_wind_does_not_change_what_is_found(model: Model) -> None:
    for force in (-1.5, 1.5):
        met, _, _ = felt(model, 0.15, lambda time, force=force: force, seconds=10.0)
        assert met is not None and met[0] == pytest.approx(0.15, abs=0.003)


def test_a_gust_beside_the_direction_is_held_against(model: Model) -> None:
    steady, gust = np.array([0.4, 0.3, 0.2]), np.array([0.5, 0.9, -0.6])
    feeler = Feeler(model, np.zeros(3), 0.0, INTO, 0.08, steady)
    estimate: Any = SimpleNamespace(time=0.0, velocity=np.zeros(3), wind=steady + gust, arm_angles=model.start_arm)
    setpoint = feeler.step(estimate, np.zeros(3), TICK)
    np.testing.assert_allclose(model.vehicle.mass * setpoint.acceleration, [0.0, -0.9, 0.0], atol=1e-12)
