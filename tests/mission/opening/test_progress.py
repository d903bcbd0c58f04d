"""How far a door is on its way, and for how long it has got no farther."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from doorman.control.estimation.estimator import Estimate, Estimator, Tie
from doorman.control.state_converter import StateConverter
from doorman.mission.opening.progress import Progress
from doorman.model import GRAVITY, Model
from doorman.signals import Measurement

TICK = 0.02


@pytest.fixture(scope="module")
def seen() -> tuple[Model, Estimate]:
    """What a vehicle at rest that grips the closed leaf knows."""
    model = Model("paper")
    attitude, arm = model.start_state[:3], model.start_arm
    place = model.coupling.vehicle_position(attitude, model.start_angle, arm)
    measured = Measurement(0.0, place, np.zeros(3), attitude, np.zeros(3), arm, np.zeros(len(arm)), 0.0)
    lift = np.array([0.0, 0.0, model.vehicle.mass * GRAVITY])
    return model, Estimator(model, StateConverter(model)).update(measured, lift, Tie.GRIPPED, TICK)


def watched(model: Model, first: Estimate, progress: Progress, off: float, since: float, seconds: float) -> float:
    """A door that stands this far from the goal for so long; returns the time [s]."""
    state = first.state.copy()
    state[3:5] = model.goal_angle + off, 0.0
    now = since
    for _ in range(round(seconds / TICK)):
        now += TICK
        progress.update(replace(first, time=now, state=state), False, TICK)
    return now


@pytest.mark.parametrize(("beside", "stuck"), [(math.radians(1.5), 2.0), (math.radians(3.0), 17.0)])
def test_a_door_that_leaves_the_goal_has_time_to_come_back(
    seen: tuple[Model, Estimate], beside: float, stuck: float
) -> None:
    """15 s so far from the goal, and then 2 s farther away."""
    model, first = seen
    progress = Progress(model, pushes=False)
    progress.resume(0.0)
    now = watched(model, first, progress, beside, 0.0, 15.0)
    now = watched(model, first, progress, math.radians(3.2), now, 2.0)
    assert progress.stuck_for(now) == pytest.approx(stuck, abs=0.1)
