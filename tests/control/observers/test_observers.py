"""Disturbance observers of vehicle and door against the transfer functions and plants that they are made for."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.control.observers.disturbance_observer import DisturbanceObserver
from doorman.control.observers.door_observer import DoorObserver
from doorman.model import Model
from doorman.scenario import Scenario

MASS, STEP = 3.0, 0.004


def estimates(observer: DisturbanceObserver, disturbance, duration: float, start=(1.0, -2.0, 0.5)) -> np.ndarray:
    """Estimates while a free mass obeys m p̈ = F + δ, with F chosen to cancel the estimate."""
    position, velocity, force = np.array(start), np.zeros(3), np.zeros(3)
    found = []
    for k in range(round(duration / STEP)):
        found.append(observer.update(position.copy(), force, STEP).copy())
        force = -found[-1]
        velocity = velocity + STEP * (force + disturbance(k * STEP)) / MASS
        position = position + STEP * velocity
    return np.array(found)


@pytest.mark.parametrize("rate", [1.0, 4.0])
def test_step_response_is_that_of_q(rate: float) -> None:
    load = np.array([2.0, -1.0, 0.5])
    found = estimates(DisturbanceObserver(MASS, rate), lambda _: load, 8.0 / rate)
    time = np.arange(len(found)) * STEP
    expected = 1.0 - (1.0 + rate * time) * np.exp(-rate * time)  # critically damped second order
    np.testing.assert_allclose(found, expected[:, None] * load, atol=0.03 * np.abs(load).max())


def test_starts_without_a_bump() -> None:
    observer = DisturbanceObserver(MASS, 5.0)
    assert observer.update(np.array([3.0, 4.0, 5.0]), np.zeros(3), 0.0) == pytest.approx(np.zeros(3))


def test_bound_and_recovery() -> None:
    observer = DisturbanceObserver(MASS, 1.0, limit=10.0)
    found = estimates(observer, lambda t: np.array([12.0 if t < 30.0 else 0.0, 0.0, 0.0]), 34.0)[:, 0]
    assert found.max() == pytest.approx(10.0)
    leaves = np.flatnonzero(found[round(30.0 / STEP) :] < 9.9)[0] * STEP
    assert leaves < 1.0  # it does not have to unwind what it gathered at the bound


@pytest.mark.parametrize("step", [0.005, 0.1, 0.2])
def test_the_bound_is_left_as_it_was_reached_however_long_the_ticks(step: float) -> None:
    rate, load = 3.0, np.array([12.0, 0.0, 0.0])
    observer = DisturbanceObserver(MASS, rate, limit=10.0)
    fixed, found = np.zeros(3), []
    for _ in range(round(10.0 / step)):  # it hovers against the load
        found.append(observer.update(fixed, -load, step)[0])
    assert max(found) == 10.0 and found[-1] == 10.0
    for _ in range(round(3.0 / step)):
        found.append(observer.update(fixed, np.zeros(3), step)[0])
    assert min(found) > -1.0
    assert abs(found[-1]) < 0.1


def test_door_observer_finds_friction_of_a_moving_and_of_a_stuck_door(model) -> None:
    lever = model.coupling.distance_from_hinge
    inertia = model.door.inertia + model.vehicle.mass * lever**2
    observer = DoorObserver(model, rate=2.0, limit=5.0)
    angle, rate, friction = np.pi / 2, 0.0, 0.8
    for push in (0.5, 3.0):  # stuck, then moving; N along the normal
        for _ in range(round(4.0 / STEP)):
            observer.update(angle, rate, push, model.door.inertia, STEP)
            torque = -push * lever
            stuck = rate == 0.0 and abs(torque) <= friction
            acceleration = 0.0 if stuck else (torque + friction) / inertia
            rate += STEP * acceleration
            angle += STEP * rate
        resistance = min(push * lever, friction)
        assert observer.estimate == pytest.approx(-resistance, rel=0.02)


@pytest.mark.parametrize("whole", [False, True])
def test_door_observer_leaves_out_or_holds_what_the_scenario_names(whole: bool) -> None:
    named = Model(Scenario.load("paper", {"door.stiffness": 1.2, "door.damping": 0.8}))
    observer = DoorObserver(named, rate=2.0, limit=5.0, whole=whole)
    angle, rate = named.door.rest_angle - 0.5, -0.1
    closer = 1.2 * 0.5 + 0.8 * 0.1
    for _ in range(round(4.0 / STEP)):
        observer.update(angle, rate, 2.0, named.door.inertia, STEP)
    pushed = 2.0 * named.coupling.lever_length
    assert observer.estimate == pytest.approx(-pushed if whole else closer - pushed, abs=0.01)
    observer.restart(-0.7)
    assert observer.update(angle, rate, 0.7 / named.coupling.lever_length, named.door.inertia, 0.0) == observer.estimate
    assert observer.estimate == pytest.approx(-0.7)


def test_door_observer_bound_and_switch(model) -> None:
    bounded, off = DoorObserver(model, rate=2.0, limit=1.0), DoorObserver(model, rate=0.0, limit=1.0)
    for _ in range(2000):
        bounded.update(1.0, 0.0, 17.0, 5.0, STEP)
        off.update(1.0, 0.0, 17.0, 5.0, STEP)
    assert bounded.estimate == -1.0
    assert off.estimate == 0.0
    for _ in range(400):
        bounded.update(1.0, 0.0, 0.0, 5.0, STEP)
    assert abs(bounded.estimate) < 0.1
