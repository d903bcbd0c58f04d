"""The tip's kernel against the coupling, and the leaf's kernels against the door."""

import numpy as np
import pytest

from doorman.control.kernels.tip import TipMotion, tip_on_leaf
from doorman.kinematics.doors.leaf.leaf_kernels import angle_of_point, leaf_normal, leaf_numbers
from doorman.kinematics.vehicles.arms.arm import ArmParameters
from doorman.model import Model
from doorman.numba_types.handles import held
from doorman.scenario import Scenario
from doorman.signals import Measurement

DOORS = ("push", "pull", "drawer", "hatch")


@pytest.fixture(scope="module", params=DOORS)
def model(request: pytest.FixtureRequest) -> Model:
    return Model(Scenario.load(f"shipped:{request.param}"))


def measured(model: Model, random: np.random.Generator) -> Measurement:
    at = model.hover_offset + random.normal(0.0, 0.3, 3) + model.door.hinge_position
    arm = random.normal(0.0, 0.5, (2, model.n_arm))
    return Measurement(0.0, at, *random.normal(0.0, 0.4, (3, 3)), arm[0], arm[1], 0.0)


def test_the_tip_is_where_the_coupling_has_it(model: Model) -> None:
    arm, leaf, lever = held(ArmParameters.of(model.vehicle.arm)), leaf_numbers(model.door), model.coupling.lever_length
    random = np.random.default_rng(2)
    for _ in range(50):
        seen, velocity = measured(model, random), random.normal(0.0, 0.5, 3)
        parts = seen.attitude, seen.body_rates, seen.arm_angles, seen.arm_rates
        expected = model.coupling.door_state(seen.position, velocity, *parts)
        found = tip_on_leaf(arm, leaf, lever, seen.position, velocity, *parts, TipMotion())
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def test_the_leaf_is_the_doors(model: Model) -> None:
    leaf, door = leaf_numbers(model.door), model.door
    for angle in np.linspace(door.lower_limit, door.upper_limit, 7).tolist():
        np.testing.assert_allclose(leaf_normal(leaf, angle), door.normal(angle), rtol=1e-12, atol=1e-12)
        point = door.contact_point(angle, 0.4, 0.3)
        expected = door.angle_of(point - door.hinge_position)
        assert angle_of_point(leaf, *point.tolist()) == pytest.approx(expected, rel=1e-12)
