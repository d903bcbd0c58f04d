"""Thrust and mass that are not what is believed are learnt, and counted on."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.control.estimation.lift_scale import LiftScale
from doorman.mission import simulate
from doorman.scenario import Scenario
from doorman.signals import Command


def test_what_rotors_make_at_their_limit_is_less_than_was_wanted():
    lift = LiftScale(60.0)
    lift.learn(-0.2)
    near, far = (Command(thrust, np.zeros(3), np.zeros(0)) for thrust in (40.0, 60.0))
    np.testing.assert_allclose(lift.made(lift.scaled(near).body_force), near.body_force)
    assert lift.scaled(near).thrust == pytest.approx(50.0) and lift.reach == pytest.approx(0.8)
    assert lift.made(lift.scaled(far).body_force)[2] == pytest.approx(48.0)


def test_another_vehicle_is_not_believed():
    lift = LiftScale(40.0)
    lift.learn(2.0)
    assert lift.scale == 1.3
    lift.learn(-0.6)
    assert lift.scale == 0.7
    assert lift.command(38.0) == 40.0, "rotors have a limit"
    assert lift.command(41.0) == 41.0


@pytest.mark.slow
@pytest.mark.parametrize("changes", [{"simulation.thrust_scale": 0.9}, {"simulation.vehicle_mass": 3.3}], ids=str)
def test_a_push_with_less_lift_than_is_believed_opens_the_door(changes):
    flight = simulate(Scenario.load("push", changes), seed=7)
    figures = flight.summary
    assert figures["outcome"] == "completed" and figures["collisions"] == 0
    assert figures["final_door_angle_deg"] == pytest.approx(20.0, abs=1.0) and figures["max_push_force_n"] < 6.0
