"""What is known of a leaf in the gripper: the tip's force, from the push and from what the hinge resists with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from doorman.control.estimation.estimator import Estimator, Tie
from doorman.control.held_leaf import HeldLeaf
from doorman.control.state_converter import StateConverter
from doorman.control.whole_body_control import WholeBodyController
from doorman.model import Model
from doorman.planning.whole_body.contact import contact_forces
from doorman.planning.whole_body.numbers import grip_numbers, whole_body_numbers
from doorman.scenario import Scenario
from doorman.signals import Measurement


@pytest.mark.parametrize(
    ("scenario", "torque", "push"), [("paper", -0.7, 3.0), ("pull", 0.5, -2.0), ("drawer", 0.6, -4.0)]
)
def test_the_tip_bears_what_moves_the_leaf_and_what_the_hinge_takes(scenario: str, torque: float, push: float) -> None:
    """Leaf and vehicle move as one: the tip's force gives both the acceleration that the push gives their sum."""
    model = Model(Scenario.load(scenario, {"planner.model": "whole_body"}))
    converter = StateConverter(model)
    place = model.coupling.vehicle_position(model.start_state[:3], model.start_angle, model.start_arm)
    rest, still = np.zeros(3), np.zeros(model.n_arm)
    seen = Measurement(0.0, place, rest, model.start_state[:3], rest, model.start_arm, still, 0.0)
    known = Estimator(model, converter).update(seen, np.array([0.0, 0.0, model.vehicle.weight]), Tie.GRIPPED, 0.0)
    at_rest = model.door.stiffness * (known.door_angle - model.door.rest_angle)
    known = replace(known, door_disturbance=torque - at_rest, push=push)
    held = HeldLeaf(model, converter).update(known, seen, np.array([0.0, 0.0, model.vehicle.weight]), 0.004)
    lever, inertia, mass = model.coupling.lever_length, known.hinge.inertia, model.vehicle.mass
    whole = torque + model.door.weight_torque(known.door_angle) + model.door.damping * known.door_rate
    gains = -(lever * push + whole) / (inertia + mass * lever**2)
    assert -(lever * held.normal_force + whole) / inertia == pytest.approx(gains)
    assert (push - held.normal_force) / mass == pytest.approx(-lever * gains)
    assert held.touching and held.resistance == pytest.approx(model.travel.ahead(torque), abs=1e-3)
    controller = WholeBodyController(model)
    controller.forget(grips=True)
    controller.aim(held, 0.0, 0.004)
    state, given = controller.start(held)
    numbers = whole_body_numbers(model).replaced({**grip_numbers(model), **given})
    assert contact_forces(numbers, model, state[None])[0] == pytest.approx(held.normal_force, abs=1e-6)


def test_a_leaf_that_goes_back_is_planned_to_where_it_was_found() -> None:
    model = Model(Scenario.load("pull"))
    controller = WholeBodyController(model)
    controller.forget(grips=True, goal=model.start_angle)
    converter = StateConverter(model)
    posture = model.on_the_way(model.goal_angle)
    place = model.coupling.vehicle_position(posture[:3], model.goal_angle, posture[5:])
    rest, still = np.zeros(3), np.zeros(model.n_arm)
    seen = Measurement(0.0, place, rest, posture[:3], rest, posture[5:], still, 0.0)
    known = Estimator(model, converter).update(seen, np.array([0.0, 0.0, model.vehicle.weight]), Tie.GRIPPED, 0.0)
    held = HeldLeaf(model, converter).update(known, seen, np.array([0.0, 0.0, model.vehicle.weight]), 0.004)
    for tick in range(250):
        controller.aim(held, 0.004 * tick, 0.004)
    _, given = controller.start(held)
    assert given["reference.joint"] == model.start_angle and controller.opening_rate > 0.1
    assert given["reference.heading"][0] == pytest.approx(float(model.start_state[2]))
    np.testing.assert_allclose(given["reference.arm"], model.start_arm)
