"""Thrust and mass that are not what is believed are learnt in hover."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.control.estimation.lift_scale import LiftScale
from doorman.control.observers.vehicle_observer import VehicleObserver
from doorman.gravity import GRAVITY
from doorman.mission import simulate
from doorman.scenario import Scenario
from doorman.signals import Command

MASS, TICK = 3.0, 0.004
WEIGHT = MASS * GRAVITY


def hovered(true: float, seconds: float = 4.0, noise: float = 0.0) -> LiftScale:
    """A vehicle on a spring-like height control, whose rotors make `true` of what they are told."""
    random, lift, observer = np.random.default_rng(1), LiftScale(WEIGHT, 60.0), VehicleObserver(MASS, 15.0)
    height, speed, wanted, up = 0.0, 0.0, WEIGHT, np.array([0.0, 0.0, 1.0])
    for index in range(round(seconds / TICK)):
        now = index * TICK
        observer.update((height + noise * random.standard_normal()) * up, now, now, (wanted - WEIGHT) * up, TICK)
        lift.learn(float(observer.outer_force[2]), TICK)
        wanted = (
            WEIGHT - MASS * (6.0 * observer.position[2] + 4.5 * observer.velocity[2]) - float(observer.outer_force[2])
        )
        speed += TICK * (true * lift.command(wanted) / MASS - GRAVITY)
        height += TICK * speed
    return lift


def test_what_rotors_make_at_their_limit_is_less_than_was_wanted():
    lift = hovered(0.8, 10.0)
    near, far = (Command(thrust, np.zeros(3), np.zeros(0)) for thrust in (40.0, 60.0))
    np.testing.assert_array_equal(lift.made(near, lift.scaled(near)), near.body_force)
    assert lift.reach == pytest.approx(0.8, abs=0.01)
    assert lift.made(far, lift.scaled(far))[2] == pytest.approx(60.0 * lift.scale)


@pytest.mark.parametrize("true", [0.8, 0.93, 1.0, 1.2])
@pytest.mark.parametrize("noise", [0.0, 0.001])
def test_what_the_rotors_make_is_learnt_in_some_seconds_of_hover(true, noise):
    assert hovered(true, noise=noise).scale == pytest.approx(true, abs=0.12 * abs(true - 1.0) + 0.01)
    assert hovered(true, 10.0, noise).scale == pytest.approx(true, abs=0.01)


def test_another_vehicle_is_not_believed():
    assert hovered(0.4).scale >= 0.7 and hovered(3.0).scale <= 1.3
    lift = LiftScale(WEIGHT, 40.0)
    for _ in range(1000):
        lift.learn(-5.0, TICK)
    assert lift.command(38.0) == 40.0, "rotors have a limit"
    assert lift.command(41.0) == 41.0


@pytest.mark.slow
@pytest.mark.parametrize("changes", [{"simulation.thrust_scale": 0.9}, {"simulation.vehicle_mass": 3.3}], ids=str)
def test_a_push_with_less_lift_than_is_believed_opens_the_door(changes):
    flight = simulate(Scenario.load("push", changes), seed=7)
    figures = flight.summary
    assert figures["outcome"] == "completed" and figures["collisions"] == 0
    assert figures["final_door_angle_deg"] == pytest.approx(20.0, abs=1.0) and figures["max_push_force_n"] < 6.0
