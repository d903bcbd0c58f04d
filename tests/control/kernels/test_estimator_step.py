"""The estimators' kernels against plain Python, tick by tick, on motions that pass through every branch."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from plain_estimator import PlainEstimator
from plain_leaf_estimator import PlainLeafEstimator

from doorman.compilation import kernel_counts
from doorman.control.estimation.estimator import Estimator, Tie
from doorman.control.estimation.leaf_estimator import LeafEstimator
from doorman.control.state_converter import StateConverter
from doorman.exceptions import DimensionError, SingularityError
from doorman.gravity import GRAVITY
from doorman.model import Model
from doorman.signals import Measurement

Array = np.ndarray
TICK = 0.004


@pytest.fixture(
    scope="module",
    params=["push", *(pytest.param(name, marks=pytest.mark.slow) for name in ("pull", "drawer_close", "hatch"))],
)
def model(request: pytest.FixtureRequest) -> Model:
    return Model(request.param)


def flown(model: Model, distances: list[float], seed: int, old: float = 0.0) -> list[tuple[Measurement, Array]]:
    """What the sensors say of a vehicle whose tip comes to these distances from the leaf, one a second, and its rotors' force."""
    random, angle = np.random.default_rng(seed), model.start_angle
    posture = model.on_the_way(angle)
    rest = np.array([0.0, 0.0, float(posture[2])])
    place, normal = model.coupling.vehicle_position(rest, angle, posture[5:]), model.door.normal(angle)
    said, seconds = [], np.arange(len(distances), dtype=float)
    for k in range(round((len(distances) - 1) / TICK)):
        now = k * TICK
        away = float(np.interp(now, seconds, distances))
        at = place - away * normal + random.normal(0.0, 2e-4, 3)
        attitude = rest + random.normal(0.0, 0.01, 3) + np.array([0.0, 0.0, 2.0 * np.pi * (k % 3 - 1)])
        rates, arm = random.normal(0.0, 0.05, 3), random.normal(0.0, 0.01, (2, model.n_arm))
        seen_at = now - old * (k % 4)
        force = (
            np.array([0.0, 0.0, model.vehicle.mass * GRAVITY])
            + random.normal(0.0, 0.3, 3)
            + (away < 0.0) * 1.5 * normal
        )
        said.append(
            (Measurement(now, at, rates, attitude, rates, posture[5:] + arm[0], arm[1], seen_at, seen_at), force)
        )
    return said


def assert_same(fast: object, plain: object, tick: int) -> None:
    for field in fields(fast):  # type: ignore[arg-type]
        one, other = getattr(fast, field.name), getattr(plain, field.name)
        if hasattr(one, "__dataclass_fields__"):
            assert_same(one, other, tick)
        else:
            np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-11, err_msg=f"{field.name} at tick {tick}")


TIES = (Tie.FREE, Tie.PUSHING, Tie.PUSHING, Tie.GRIPPED, Tie.GRIPPED, Tie.LEAVING, Tie.PUSHING, Tie.PUSHING, Tie.FREE)


@pytest.mark.parametrize("old", [pytest.param(0.0, marks=pytest.mark.slow), 0.011])
def test_the_estimate_is_the_plain_one(model: Model, old: float) -> None:
    converter = StateConverter(model)
    fast, plain = Estimator(model, converter), PlainEstimator(model, converter)
    said, met = flown(model, [0.2, 0.1, -0.002, -0.01, -0.03, -0.05, 0.0, 0.05, -0.05, 0.1], 3, old), False
    for k, (seen, force) in enumerate(said):
        tie = TIES[min(k // 250, len(TIES) - 1)]
        found, expected = (each.update(seen, force, tie, TICK if k else 0.0) for each in (fast, plain))
        assert_same(found, expected, k)
        met |= found.touching and tie is Tie.PUSHING
        for each in (fast, plain):
            each.tell(seen.attitude + 0.01)
            if k == 600:
                each.contact.expect()
            if k == 1600:
                each.meet_leaf(found.tip_angle, found.wind)
            if k == 1800:
                each.lose_leaf()
    assert met, "some of it was contact"


@pytest.mark.parametrize(
    ("speed", "sensed"),
    [(0.4, True), *(pytest.param(*case, marks=pytest.mark.slow) for case in ((0.0, False), (0.4, False), (0.0, True)))],
)
def test_the_leafs_estimate_is_the_plain_one(model: Model, speed: float, sensed: bool) -> None:
    converter = StateConverter(model)
    fast, plain = LeafEstimator(model, converter), PlainLeafEstimator(model, converter)
    distances = [0.2, 0.1, -0.001, -0.002, -0.04, -0.08, -0.08, -0.03, 0.1, 0.02, -0.06, -0.06]
    touched = []
    for k, (seen, force) in enumerate(flown(model, distances, 5, 0.011)):
        seeks = 300 <= k < 2000 or k > 2200
        if sensed and k % 700 > 5:  # it fails now and then
            seen = replace(seen, tip_force=0.1 + (1.5 if 500 < k < 1600 or k > 2400 else 0.0) + float(force[0]) / 20.0)
        found, expected = (each.update(seen, force, TICK if k else 0.0, seeks, speed) for each in (fast, plain))
        assert_same(found, expected, k)
        touched.append(found.touching)
    assert any(touched) and not all(touched[500:]), "it came and went"


def test_no_kernel_is_made_in_flight(model: Model) -> None:
    converter = StateConverter(model)
    estimator, leaf = Estimator(model, converter), LeafEstimator(model, converter)
    before = kernel_counts()
    for k, (seen, force) in enumerate(flown(model, [0.1, -0.01, -0.03, 0.1], 2)):
        estimator.update(seen, force, Tie.PUSHING if k % 2 else Tie.GRIPPED, TICK)
        leaf.update(seen, force, TICK, k > 100, 0.1)
    estimator.meet_leaf(1.5, np.zeros(3))
    estimator.lose_leaf()
    assert kernel_counts() == before


def test_what_cannot_be_estimated_is_named(model: Model) -> None:
    converter, (seen, force) = StateConverter(model), flown(model, [0.1, 0.0], 2)[0]
    upright, nowhere = seen.attitude.copy(), seen.position.copy()
    upright[1], nowhere[1] = 0.5 * np.pi, np.nan
    for error, bad in (
        (SingularityError, replace(seen, attitude=upright)),
        (DimensionError, replace(seen, position=nowhere)),
    ):
        with pytest.raises(error):
            Estimator(model, converter).update(bad, force, Tie.FREE, TICK)
        with pytest.raises(error):
            LeafEstimator(model, converter).update(bad, force, TICK, False, 0.0)
