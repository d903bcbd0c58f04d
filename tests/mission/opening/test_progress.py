"""How far a door is on its way, and for how long it has got no farther."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from doorman.control.estimation.estimator import Estimate, Estimator, Tie
from doorman.control.state_converter import StateConverter
from doorman.mission.opening.progress import Progress
from doorman.model import Model
from doorman.signals import Measurement

TICK = 0.02


@pytest.fixture(scope="module")
def seen() -> tuple[Model, Estimate]:
    """What a vehicle at rest that grips the closed leaf knows."""
    model = Model("paper")
    attitude, arm = model.start_state[:3], model.start_arm
    place = model.coupling.vehicle_position(attitude, model.start_angle, arm)
    measured = Measurement(0.0, place, np.zeros(3), attitude, np.zeros(3), arm, np.zeros(len(arm)), 0.0)
    return model, Estimator(model, StateConverter(model)).update(measured, Tie.GRIPPED, True, TICK)


def watched(
    model: Model, first: Estimate, progress: Progress, off: float, since: float, seconds: float, held: bool = False
) -> float:
    """A door that stands this far from the goal for so long; returns the time [s]."""
    state = first.state.copy()
    state[3:5] = model.goal_angle + off, 0.0
    now = since
    for _ in range(round(seconds / TICK)):
        now += TICK
        progress.update(replace(first, time=now, state=state, rests=True), held)
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


@pytest.mark.parametrize(("beside", "there"), [(1.0, True), (-1.0, True), (-1.9, True), (-2.5, False), (-10.0, False)])
def test_a_pushed_door_is_open_where_it_is_held_near_the_goal(
    seen: tuple[Model, Estimate], beside: float, there: bool
) -> None:
    """Degrees from the goal, positive before it: one that was pushed far past it was not opened as asked."""
    model, first = seen
    progress = Progress(model, pushes=True)
    progress.resume(0.0)
    now = watched(model, first, progress, math.radians(beside), 0.0, 5.0, held=True)
    assert progress.done(now) is there


def swinging(model: Model, first: Estimate, progress: Progress, amplitude: float, seconds: float) -> float:
    """A gripped door that swings about the goal once in 1.3 s; returns the time [s]."""
    pace = 2.0 * math.pi / 1.3
    for k in range(round(seconds / TICK)):
        now = (k + 1) * TICK
        state = first.state.copy()
        state[3] = model.goal_angle + amplitude * math.sin(pace * now)
        state[4] = amplitude * pace * math.cos(pace * now)
        progress.update(replace(first, time=now, state=state, rests=False), False)
    return now


@pytest.mark.parametrize(("degrees", "seconds", "there"), [(1.8, 30.0, True), (1.8, 4.0, False), (2.5, 30.0, False)])
def test_a_gripped_door_that_swings_about_the_goal_is_there_after_a_while(
    seen: tuple[Model, Estimate], degrees: float, seconds: float, there: bool
) -> None:
    model, first = seen
    progress = Progress(model, pushes=False)
    progress.resume(0.0)
    assert progress.done(swinging(model, first, progress, math.radians(degrees), seconds)) is there


@pytest.mark.parametrize(("degrees", "seconds", "there"), [(0.2, 1.5, True), (0.8, 1.5, False), (0.8, 5.0, True)])
def test_friction_may_keep_a_gripped_door_a_little_away_from_the_goal(
    seen: tuple[Model, Estimate], degrees: float, seconds: float, there: bool
) -> None:
    model, first = seen
    progress = Progress(model, pushes=False)
    progress.resume(0.0)
    assert progress.done(watched(model, first, progress, math.radians(degrees), 0.0, seconds)) is there


@pytest.mark.parametrize("pushes", [True, False])
def test_a_door_that_does_not_rest_is_not_open_yet(seen: tuple[Model, Estimate], pushes: bool) -> None:
    model, first = seen
    progress = Progress(model, pushes)
    progress.resume(0.0)
    for k in range(150):
        state = first.state.copy()
        state[3:5] = model.goal_angle, 0.0
        progress.update(replace(first, time=TICK * k, state=state, rests=False), pushes)
    assert not progress.done(3.0)
