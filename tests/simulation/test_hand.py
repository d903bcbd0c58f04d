"""A hand on the leaf: when it comes and goes, and that it holds a real leaf, or shoves it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.exceptions import ScenarioError
from doorman.hardware.interface import Command
from doorman.scenario import HandSection
from doorman.simulation import Disturbance, SimulatedBackend
from doorman.simulation.hand import Hand


def test_it_comes_where_the_leaf_is_open_that_far_and_goes_for_good():
    hand = Hand(HandSection(door_angle=1.0, duration=2.0, shove=1.5))
    seen = [(0.0, 1.2), (0.5, 1.01), (1.0, 1.0), (2.9, 1.3), (3.0, 0.9), (9.0, 0.5)]
    assert [hand.at(time, angle, 0.0).hinge_torque for time, angle in seen] == [0.0, 0.0, 1.5, 1.5, 0.0, 0.0]
    assert Hand(HandSection(shove=1.5)).at(1.0, -1.0, 0.0) == Disturbance(), "by default nobody comes"


def test_it_holds_with_no_more_than_its_torque():
    hand = Hand(HandSection(door_angle=1.0, hold=4.0, shove=0.5))
    assert hand.at(0.0, 0.99, 0.0).hinge_torque == 0.5
    torques = [hand.at(0.1, angle, rate).hinge_torque for angle, rate in ((0.9, 0.0), (1.2, 0.0), (0.99, -1.0))]
    assert torques == [4.5, -3.5, 4.5]
    assert hand.at(0.2, 0.989, 0.0).hinge_torque == pytest.approx(0.5 + 4.0 * 0.001 / 0.005)


def swing(model, seconds: float, **hand: float) -> list[tuple[float, float]]:
    """Door angle and rate of a leaf that 3 N m drive open, with a hand."""
    scene = model(
        contact__kind="push", mission__start="hover", simulation__door_friction=0.0, simulation__door_damping=3.0,
        **{f"simulation__hand__{key}": value for key, value in hand.items()},
    )  # fmt: skip
    backend, found = SimulatedBackend(scene, disturbance=lambda time: Disturbance(hinge_torque=-3.0)), []
    with backend:
        for _ in range(round(seconds * 250)):
            backend.read()
            backend.command(Command(3.0 * 9.81, np.zeros(3), np.zeros(4)))
            found.append((backend.truth.door_angle, backend.truth.door_rate))
    return found


def test_a_held_leaf_stands_and_goes_on_when_it_is_let_go(model):
    motion = np.array(swing(model, 3.2, door_angle=1.4, hold=15.0, duration=1.2))
    came = int(np.flatnonzero(motion[:, 0] <= 1.4)[0])
    held = motion[came + 200 : came + 290]  # 0.8 to 1.16 s later
    assert np.abs(held[:, 0] - (1.4 - 0.005 * 3.0 / 15.0)).max() < 2e-3 and np.abs(held[:, 1]).max() < 5e-3
    assert motion[-1, 1] < -0.2


def test_a_hand_that_is_too_weak_gives_way(model):
    free, held = (swing(model, 1.6, door_angle=1.4, hold=hold, duration=1.0)[-1][0] for hold in (0.0, 2.0))
    assert free < held < 1.38


def test_a_shove_shuts_and_opens(model):
    still, shut, opened = (swing(model, 1.2, door_angle=1.5, shove=torque)[-1][0] for torque in (0.0, 6.0, -2.0))
    assert opened < still - 0.05 and shut > still + 0.2


def test_a_hand_at_no_angle_of_a_door_is_an_error():
    with pytest.raises(ScenarioError, match="door_angle"):
        HandSection(door_angle=2 * math.pi)
