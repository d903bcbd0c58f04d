"""Plans and commands of a tip at the leaf, joined with its estimate as in a mission."""

from __future__ import annotations

import numpy as np
import pytest

from doorman import Planner, Scenario
from doorman.cli.recordings.replayed import replay_plans
from doorman.control.estimation.estimator import Estimate, Estimator, Tie
from doorman.control.state_converter import StateConverter
from doorman.gravity import GRAVITY
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.mission.following import Following
from doorman.mission.schedule import PlanSchedule
from doorman.model import Model
from doorman.recording import Recorder
from doorman.signals import Command, Measurement

TICK = 0.004


@pytest.fixture(scope="module")
def planner() -> Planner:
    return Planner(Scenario.load("push"))


class Hovering:
    """A vehicle that stands before the closed leaf while rotors press, and what is made of that."""

    def __init__(self, planner: Planner, away: float, latency: int = 0) -> None:
        model = self.model = planner.model
        self.recorder = Recorder(None, {})
        self.schedule = PlanSchedule(planner, latency, self.recorder)
        converter = StateConverter(model)
        self.flight, self.estimator = Following(converter, self.schedule), Estimator(model)
        self.tick, angle = 0, model.start_angle
        self.attitude = np.array([0.0, 0.0, model.start_yaw])
        self.normal = model.door.normal(angle)
        self.place = model.coupling.vehicle_position(self.attitude, angle, model.start_arm) - away * self.normal

    def fly(self, seconds: float, push: float, at_the_leaf: bool) -> tuple[Estimate, Command | None]:
        model, rest = self.model, np.zeros(3)
        force = np.array([0.0, 0.0, model.vehicle.mass * GRAVITY]) + push * self.normal
        for _ in range(round(seconds / TICK)):
            now = self.tick * TICK
            seen = Measurement(now, self.place, rest, self.attitude, rest, model.start_arm, np.zeros(model.n_arm), now)
            step = TICK if self.tick else 0.0
            self.estimator.tell(rotation_body_to_world(self.attitude).T @ force)
            known = self.estimator.update(seen, Tie.PUSHING if at_the_leaf else Tie.FREE, False, step)
            command = self.flight.follow(known, seen, at_the_leaf, None, step)
            self.tick += 1
        return known, command


def test_at_the_leaf_it_plans_once_a_period_and_flies_towards_it(planner: Planner) -> None:
    hovering = Hovering(planner, 0.1)
    hovering.fly(2.0, 0.0, at_the_leaf=False)
    known, command = hovering.fly(0.5, 0.0, at_the_leaf=True)
    assert not known.touching and command is not None
    up = command.thrust * rotation_body_to_world(command.attitude)[:, 2]
    assert up @ hovering.normal > 0.05 and up[2] == pytest.approx(hovering.model.vehicle.mass * GRAVITY, rel=0.1)
    plans = hovering.recorder.recording()["plan"]
    assert len(plans.time) == pytest.approx(0.5 * planner.settings.rate, abs=2)
    assert plans["cold"].sum() == 1 and (plans["iterations"][~plans["cold"]] <= planner.settings.iterations).all()


def test_a_plan_is_used_when_it_would_be_known(planner: Planner) -> None:
    hovering = Hovering(planner, 0.1, latency=3)
    hovering.fly(1.0, 0.0, at_the_leaf=False)
    hovering.fly(0.3, 0.0, at_the_leaf=True)
    plans = hovering.recorder.recording()["plan"]
    late = plans["available_at"] - plans.time
    np.testing.assert_allclose(late[~plans["cold"]], 3.0 * hovering.schedule.period, atol=1e-9)


def test_recorded_plans_are_made_again_to_the_bit(planner: Planner) -> None:
    hovering = Hovering(planner, 0.05)
    hovering.fly(1.0, 0.0, at_the_leaf=False)
    hovering.fly(0.3, 0.0, at_the_leaf=True)
    found = replay_plans(hovering.recorder.recording(), Planner(Model(planner.model.scenario)))
    assert found.plans > 20 and found.identical
