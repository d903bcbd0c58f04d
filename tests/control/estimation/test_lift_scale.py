"""Thrust and mass that are not what is believed are learnt, and counted on."""

from __future__ import annotations

import numpy as np
import pytest
from completed_flights import completed

from doorman.control.estimation.lift_scale import LiftScale
from doorman.signals import Command


@pytest.mark.parametrize(
    ("lift", "wanted", "commanded"),
    [(-0.2, 40.0, 50.0), (-0.2, 60.0, 60.0), (-0.2, 61.0, 61.0), (2.0, 39.0, 30.0), (-0.6, 35.0, 50.0)],
)
def test_commands_make_up_for_lift_as_far_as_rotors_and_belief_go(lift, wanted, commanded):
    scale = LiftScale(60.0)
    scale.learn(lift)
    sent = scale.scaled(Command(wanted, np.zeros(3), np.zeros(0), False, (0.1 * wanted, 0.0)))
    assert sent.thrust == pytest.approx(commanded)
    assert sent.side_force[0] == pytest.approx(0.1 * wanted / (1.0 if wanted == commanded else scale.scale))


@pytest.mark.slow
@pytest.mark.parametrize("changes", [{"simulation.thrust_scale": 0.9}, {"simulation.vehicle_mass": 3.3}], ids=str)
def test_a_push_with_less_lift_than_is_believed_opens_the_door(changes):
    completed("push", changes, 7, final_error=1.0, max_push_force_n=6.0)
