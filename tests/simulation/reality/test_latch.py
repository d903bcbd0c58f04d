"""A latch in the plant: the bolt holds the leaf until the lever is turned, and the lever's spring brings it back."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.model import Model
from doorman.scenario import Scenario
from doorman.simulation.simulator import Disturbance, Simulator
from doorman.stages import stages

PUSH = 8.0
"""On the leaf, below what the latch holds, and beyond the hinge's friction [N m]."""


@pytest.fixture(scope="module")
def steps() -> tuple[Model, ...]:
    return stages(Scenario.load("lever_pull"))


def flown(model: Model, lever: float, torque: float) -> Simulator:
    """The plant after 0.3 s in which nothing but a torque acts on the leaf, with the lever held at an angle at first."""
    simulator = Simulator(model, 0.001, lambda _: Disturbance(hinge_torque=torque))
    engine = simulator.plant.engine_model
    joint, held = engine.joint("door/lever"), simulator.plant.data
    simulator.set_grip(False)
    for _ in range(60):
        held.qpos[joint.qposadr[0]], held.qvel[joint.dofadr[0]] = lever, 0.0
        simulator.advance(5)
    return simulator


@pytest.mark.parametrize(("lever", "opens"), [(0.3, False), (0.6, True)])
def test_the_leaf_moves_when_the_lever_is_turned(steps: tuple[Model, ...], lever: float, opens: bool) -> None:
    simulator = flown(steps[-1], lever, PUSH)
    moved = simulator.plant.door_angle - steps[-1].start_angle
    assert (moved > math.radians(0.5)) == opens
    assert opens or abs(moved) < math.radians(0.1)


def test_the_lever_springs_back(steps: tuple[Model, ...]) -> None:
    simulator = flown(steps[-1], 0.6, 0.0)
    simulator.advance(1500)
    assert float(simulator.plant.data.qpos[simulator.plant.engine_model.joint("door/lever").qposadr[0]]) < 0.05


def test_a_step_begins_with_the_plant_of_the_one_before(steps: tuple[Model, ...]) -> None:
    before = Simulator(steps[0], 0.001)
    before.set_command(before.model.vehicle.weight + 1.0, (0.02, -0.01, math.pi), np.zeros(4))
    before.advance(200)
    after = Simulator(steps[1], 0.001, after=before)
    for name in ("qpos", "qvel", "act", "ctrl"):
        np.testing.assert_array_equal(getattr(after.plant.data, name), getattr(before.plant.data, name))
    was, now = before.truth(), after.truth()
    np.testing.assert_array_equal(now.position, was.position)
    np.testing.assert_array_equal(now.arm_angles, was.arm_angles)
    before.advance(50)
    after.advance(50)
    np.testing.assert_allclose(after.truth().position, before.truth().position, atol=1e-9)


@pytest.mark.parametrize("name", ["lever_pull", "lever_push"])
def test_a_tip_that_is_tied_anew_holds_no_more_than_it_held(name: str) -> None:
    first, second = stages(Scenario.load(name, {"mission.start": "contact"}))
    before = Simulator(first, 0.001)
    before.set_command(first.vehicle.weight - 3.0, (0.02, -0.01, float(first.start_state[2])), np.zeros(4))
    before.advance(200)
    held = Simulator(second, 0.001, after=before).truth().tip_force
    assert np.linalg.norm(held) < np.linalg.norm(before.truth().tip_force)
