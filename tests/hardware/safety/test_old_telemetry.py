"""What the supervisor makes of an autopilot's state that is too old, while the cameras see the vehicle."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from doorman.gravity import GRAVITY
from doorman.hardware.dynamixel import BusState, ServoFault
from doorman.hardware.mocap import PoseQuality
from doorman.hardware.mocap.sample import nothing_yet
from doorman.hardware.pixhawk import Authority, EventKind, SampleStatus, Timeouts, VehicleSample
from doorman.hardware.safety.observer import FORCE_LAG, ForceEstimator, Observer
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model

STILL = np.zeros(3)


class Vehicle:
    """An observer of a vehicle that hovers, armed and commanded, in the cameras' view."""

    def __init__(self, model: Model) -> None:
        self.now = 100.0
        self.status = SampleStatus.FRESH
        self.pose = replace(
            nothing_yet(), position=np.array([-1.0, 0.7, 1.3]), attitude=STILL, velocity=np.array([0.3, 0.0, 0.0]),
            quality=PoseQuality.MEASURED,
        )  # fmt: skip
        autopilot = SimpleNamespace(
            state=self._state, status=lambda: SimpleNamespace(conditions=frozenset(), authority=Authority.ENGAGED)
        )
        settings = SimpleNamespace(timeouts=Timeouts())
        links = SimpleNamespace(
            clock=SimpleNamespace(now=lambda: self.now), autopilot=autopilot, holding=False, gripped=False, grip_failed=False,
            servos=SimpleNamespace(read=lambda: SimpleNamespace(fault=ServoFault(0), state=BusState.FOLLOWING)),
            mocap=SimpleNamespace(read=lambda: self.pose), config=SimpleNamespace(rate=250.0, pixhawk=settings),
        )  # fmt: skip
        self.backend = SimpleNamespace(
            links=links, commanding=True, thrust=model.vehicle.mass * GRAVITY,
            attitude=np.full(3, math.nan), commanded_at=self.now, began_at=self.now, missed_ticks=0,
        )  # fmt: skip
        self._observer = Observer(model, self.backend)  # type: ignore[arg-type]

    def _state(self) -> VehicleSample:
        return VehicleSample(
            status=self.status, position_time=self.now, position=self.pose.position, velocity=STILL, attitude=STILL,
            armed=True,
        )  # fmt: skip

    def look(self, after: float = 0.02):
        self.now += after
        return self._observer.look()


def test_an_old_state_says_nothing_of_a_force(model: Model) -> None:
    vehicle = Vehicle(model)
    vehicle.look()
    assert math.isfinite(vehicle.look().force)
    vehicle.status = SampleStatus.STALE
    assert math.isnan(vehicle.look().force)


def test_an_old_state_gives_way_to_the_cameras(model: Model) -> None:
    vehicle = Vehicle(model)
    assert vehicle.look().speed == 0.0
    vehicle.status = SampleStatus.STALE
    assert vehicle.look().speed == pytest.approx(0.3)
    vehicle.pose = replace(vehicle.pose, quality=PoseQuality.LOST)
    assert math.isnan(vehicle.look().speed)


def test_a_state_that_is_new_for_a_moment_does_not_end_the_fault(model: Model) -> None:
    """A link that limps passes one state now and then; only a third of a second of new ones is a link."""
    vehicle = Vehicle(model)
    vehicle.status = SampleStatus.STALE
    vehicle.look()
    vehicle.status = SampleStatus.FRESH
    assert EventKind.STATE_STALE in vehicle.look(0.1).conditions
    assert EventKind.STATE_STALE in vehicle.look(0.15).conditions
    assert EventKind.STATE_STALE not in vehicle.look(0.15).conditions


MASS = 3.0
WEIGHT = MASS * 9.81


def sample(at: float, velocity: np.ndarray, attitude: np.ndarray) -> VehicleSample:
    return VehicleSample(position_time=at, velocity=velocity, attitude=attitude)


def fly(force: np.ndarray, thrust: float, attitude: np.ndarray, duration: float, step: float = 0.01) -> list[float]:
    """Estimates along a motion under a constant force of the surroundings."""
    lift = thrust * rotation_body_to_world(attitude)[:, 2]
    acceleration = (lift + force) / MASS - np.array([0.0, 0.0, 9.81])
    estimator = ForceEstimator(MASS)
    return [estimator.update(sample(t, t * acceleration, attitude), thrust) for t in np.arange(0.0, duration, step)]


@pytest.mark.parametrize("force", [[6.0, 0.0, 0.0], [0.0, -4.0, 2.0], [0.0, 0.0, 0.0]])
@pytest.mark.parametrize("attitude", [[0.0, 0.0, 0.0], [0.1, -0.2, 1.0]])
def test_constant_force_is_found(force, attitude):
    estimates = fly(np.array(force), 1.1 * WEIGHT, np.array(attitude), 10 * FORCE_LAG)
    assert estimates[-1] == pytest.approx(np.linalg.norm(force), abs=1e-3)


def test_it_follows_with_its_lag():
    estimates = fly(np.array([10.0, 0.0, 0.0]), WEIGHT, np.zeros(3), 1.0, step=0.01)
    after_lag = estimates[round(FORCE_LAG / 0.01)]
    assert after_lag == pytest.approx(10.0 * (1.0 - math.exp(-1.0)), rel=0.02)


def test_without_thrust_nothing_is_known_a_gap_forgets_and_the_same_sample_changes_nothing():
    estimator, still = ForceEstimator(MASS), np.zeros(3)
    for k in range(50):
        assert math.isnan(estimator.update(sample(0.01 * k, still, still), math.nan))
    for k in range(50, 100):
        last = estimator.update(sample(0.01 * k, np.array([0.02 * k, 0.0, 0.0]), still), WEIGHT)
    assert last > 0.0
    assert estimator.update(sample(0.01 * 99, np.array([1.98, 0.0, 0.0]), still), WEIGHT) == last
    assert estimator.update(sample(3.0, still, still), WEIGHT) == 0.0
