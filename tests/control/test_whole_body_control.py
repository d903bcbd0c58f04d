"""Commands that follow a whole-body plan: thrust, attitude and joint rates from what is known at one time."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from doorman.control.leaf_estimator import LeafEstimate
from doorman.control.whole_body_control import WholeBodyController, _tilted
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import GRAVITY, Model

Array = np.ndarray


@pytest.fixture(scope="module")
def model() -> Model:
    return Model("push")


@pytest.fixture(scope="module")
def controller(model: Model) -> WholeBodyController:
    return WholeBodyController(model)


def known(model: Model, distance: float, touching: bool = False, angle: float = math.pi / 2) -> LeafEstimate:
    """A level vehicle at rest with its tip this far before the contact point."""
    posture = model.on_the_way(angle)
    position = model.coupling.vehicle_position(posture[:3], angle, posture[5:]) - distance * model.door.normal(angle)
    none = np.zeros(3)
    force = 0.7 if touching else 0.0
    return LeafEstimate(
        position, none, posture[:3], none, posture[5:], angle, 0.0, touching, force, np.zeros(2), none, 0.5, 1.0,
        model.door.inertia,
    )  # fmt: skip


@pytest.mark.parametrize("yaw", [-2.0, 0.3])
def test_another_heading_keeps_the_direction_of_the_thrust(yaw: float) -> None:
    tilted = _tilted(0.1, -0.2, yaw)
    wanted = rotation_body_to_world(np.array([0.1, -0.2, 0.0]))[:, 2]
    np.testing.assert_allclose(rotation_body_to_world(tilted)[:, 2], wanted, atol=1e-12)
    assert tilted[2] == yaw


def test_before_the_leaf_it_carries_its_weight_and_goes_on(model: Model, controller: WholeBodyController) -> None:
    controller.forget()
    now = known(model, 0.1)
    command = controller.command(0.0, now, 0.004, float(now.attitude[2]))
    up = command.thrust * rotation_body_to_world(command.attitude)[:, 2]
    assert up[2] == pytest.approx(model.vehicle.mass * GRAVITY, rel=0.1)
    assert up @ model.door.normal(math.pi / 2) > 0.0
    assert not command.grip and np.abs(command.arm_rates).max() < 1.5


def test_the_rate_that_is_asked_for_grows_in_contact_and_falls_with_the_door(
    model: Model, controller: WholeBodyController
) -> None:
    controller.forget()
    now = known(model, 0.0, touching=True)
    for tick in range(250):
        controller.command(0.004 * tick, now, 0.004, float(now.attitude[2]))
    assert controller.opening_rate == pytest.approx(0.06, abs=1e-6)
    controller.command(1.0, known(model, 0.01), 0.004, float(now.attitude[2]))
    assert controller.opening_rate == 0.0


def test_a_state_that_is_none_is_rejected_and_the_last_plan_followed(
    model: Model, controller: WholeBodyController
) -> None:
    controller.forget()
    now = known(model, 0.1)
    first = controller.command(0.0, now, 0.02, 0.0)
    controller.command(0.02, replace(now, position=now.position + np.nan), 0.02, 0.0)
    assert controller.rejected >= 1
    after = controller.command(0.04, now, 0.02, 0.0)
    assert np.isfinite(after.thrust) and after.thrust == pytest.approx(first.thrust, rel=0.05)
