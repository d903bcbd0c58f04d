"""Estimators of a door that leans: its weight is known from the URDF, and passes neither for friction nor for a closer."""

from __future__ import annotations

from pathlib import Path

import pytest
from urdf_variants import write_edited

from doorman.control.estimation.beliefs import Beliefs
from doorman.control.estimation.door_filter import DoorFilter
from doorman.control.observers.door_observer import DoorObserver
from doorman.model import Model
from doorman.resources import urdf_directory
from doorman.scenario import Scenario

ORIGIN = '<origin xyz="0 0 0.01" rpy="0 0 1.5707963267948966"/>'


LIMIT = '<limit lower="0" upper="1.9"'


def leaning(path: Path, lower: float = 0.0) -> Model:
    """A room door that its weight shuts with about 2 N m, as far as the lower limit of its joint."""
    source = urdf_directory() / "door_with_handle.urdf"
    limit = LIMIT, LIMIT.replace('"0"', f'"{lower}"')
    urdf = write_edited(path, source, (ORIGIN, ORIGIN.replace("0 0 1.57", "-0.02 0 1.57")), limit)
    return Model(Scenario.load("shipped:pull", {"door.urdf": str(urdf)}))


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    return leaning(tmp_path_factory.mktemp("door") / "door.urdf")


def test_a_leaf_that_its_weight_shuts_stays_closed(model: Model) -> None:
    estimate = DoorFilter(model, Beliefs.of(model))
    for tick in range(1, 1000):
        estimate.update(0.0, False, model.travel.start, 0.004 * tick, 0.004 * tick, 0.004)
    assert model.door.opening_of(estimate.angle) == pytest.approx(0.0, abs=1e-3)


def test_a_leaf_that_its_weight_shuts_goes_on_to_the_end_of_its_joint(tmp_path: Path) -> None:
    model = leaning(tmp_path / "door.urdf", -0.1)
    assert model.door.closed == 0.0
    estimate = DoorFilter(model, Beliefs.of(model))
    for tick in range(1, 1000):
        estimate.update(0.0, False, model.travel.start, 0.004 * tick, 0.004 * tick, 0.004)
    assert model.door.opening_of(estimate.angle) == pytest.approx(-0.1, abs=1e-3)


def test_a_leaf_that_its_weight_shuts_does_not_stay_open(model: Model) -> None:
    estimate = DoorFilter(model, Beliefs.of(model))
    estimate.meet(model.door.angle_of_opening(0.8))
    assert estimate.hinge().spare == pytest.approx(
        estimate.state[4] - abs(model.door.weight_torque(estimate.angle)) - estimate.state[5] * 0.8, abs=1e-9
    )
    for tick in range(1, 1500):
        estimate.update(0.0, False, 0.0, 0.004 * tick, 0.004 * tick, 0.004)
    assert model.door.opening_of(estimate.angle) < 0.1


def test_the_observer_finds_what_the_weight_does_not_explain(model: Model) -> None:
    angle, observer = model.door.angle_of_opening(0.6), DoorObserver(model, 2.0, 5.0)
    push = -(model.door.weight_torque(angle) + 0.7) / model.coupling.lever_length
    for _ in range(2000):
        observer.update(angle, 0.0, push, model.door.inertia, 0.004)
    assert observer.estimate == pytest.approx(0.7, abs=1e-3)
