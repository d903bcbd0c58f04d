"""How far a door is on its way, whether it is open, and for how long it has got no farther."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from doorman.control.estimation.estimator import Estimate, Estimator, Tie
from doorman.mission.opening import Opening
from doorman.mission.schedule import PlanSchedule
from doorman.model import Model
from doorman.planning.planner import Planner
from doorman.recording import Recorder
from doorman.signals import Measurement

TICK = 0.02


@pytest.fixture(scope="module", params=["paper", "push"])
def seen(request: pytest.FixtureRequest) -> tuple[Model, PlanSchedule, Estimate]:
    """What a vehicle at rest at the closed leaf knows."""
    model = Model(request.param)
    attitude, arm = model.start_state[:3], model.start_arm
    place = model.coupling.vehicle_position(attitude, model.start_angle, arm)
    measured = Measurement(0.0, place, np.zeros(3), attitude, np.zeros(3), arm, np.zeros(len(arm)), 0.0)
    known = Estimator(model).update(measured, Tie.GRIPPED, True, TICK)
    return model, PlanSchedule(Planner(model), 0, Recorder(None, {})), known


class Watched:
    """A door that moves as a test has it, and what its opening takes it for."""

    def __init__(self, seen: tuple[Model, PlanSchedule, Estimate]) -> None:
        self.model, schedule, self.first = seen
        self.opening, self.now = Opening(self.model, schedule), 0.0
        self.opening.resume(0.0)

    def see(self, off: float, rate: float = 0.0, rests: bool = True) -> None:
        """One tick, so far from the goal [rad]."""
        self.now += TICK
        state = self.first.state.copy()
        state[3:5] = self.model.goal_angle + off, rate
        self.opening.update(replace(self.first, time=self.now, state=state, rests=rests))

    def stands(self, off: float, seconds: float) -> None:
        """It rests there."""
        for _ in range(round(seconds / TICK)):
            self.see(off)

    def swings(self, amplitude: float, seconds: float) -> None:
        """It swings about the goal once in 1.3 s."""
        pace = 2.0 * math.pi / 1.3
        for k in range(round(seconds / TICK)):
            turned = pace * k * TICK
            self.see(amplitude * math.sin(turned), amplitude * pace * math.cos(turned), rests=False)


@pytest.fixture
def watched(seen: tuple[Model, PlanSchedule, Estimate]) -> Watched:
    return Watched(seen)


@pytest.mark.parametrize(("beside", "stuck"), [(math.radians(1.5), 2.0), (math.radians(3.0), 17.0)])
def test_a_door_that_leaves_the_goal_has_time_to_come_back(watched: Watched, beside: float, stuck: float) -> None:
    """15 s so far from the goal, and then 2 s farther away."""
    watched.stands(beside, 15.0)
    watched.stands(math.radians(3.2), 2.0)
    assert watched.opening.stuck_for(watched.now) == pytest.approx(stuck, abs=0.1)


RESTS = [
    (0.2, 1.5, True),
    (-0.2, 1.5, True),
    (0.8, 1.5, False),
    (0.8, 5.0, True),
    (-1.0, 5.0, True),
    (-2.5, 30.0, False),
]
SWINGS = [(1.8, 12.0, True), (1.8, 4.0, False), (2.5, 30.0, False), (0.0, 3.0, False)]


@pytest.mark.parametrize(
    ("moves", "degrees", "seconds", "there"),
    [*((Watched.stands, *case) for case in RESTS), *((Watched.swings, *case) for case in SWINGS)],
)
def test_a_door_is_open_that_rests_near_the_goal_or_has_swung_about_it_for_a_while(
    watched: Watched, moves: Callable[..., None], degrees: float, seconds: float, there: bool
) -> None:
    """Friction may keep it a little away, on either side."""
    moves(watched, math.radians(degrees), seconds)
    assert watched.opening.done(watched.now) is there


@pytest.mark.parametrize(("share", "given_up"), [(1.0, 3.0), (0.5, 10.0)])
def test_a_door_that_stands_against_the_largest_push_is_not_pushed_for_long(
    watched: Watched, share: float, given_up: float
) -> None:
    """No larger push will come, and a vehicle that leans with all that it has may slip."""
    control, weight = watched.model.scenario.control, watched.model.vehicle.weight
    force = share * min(control.max_push, weight * math.tan(control.max_tilt))
    watched.first, ended = replace(watched.first, normal_force=force), math.nan
    for _ in range(round(12.0 / TICK)):
        watched.see(1.0)
        state = watched.first.state.copy()
        state[2:5] = watched.model.on_the_way(watched.model.goal_angle + 1.0)[2], watched.model.goal_angle + 1.0, 0.0
        if "does not move on" in watched.opening.stuck(replace(watched.first, time=watched.now, state=state)):
            ended = watched.now
            break
    assert ended == pytest.approx(given_up, abs=0.1)


@pytest.mark.parametrize(("degrees", "there"), [(0.5, False), (-1.0, True), (-2.5, True), (-4.0, False)])
def test_a_door_that_is_lost_a_little_past_its_goal_is_open(watched: Watched, degrees: float, there: bool) -> None:
    """By 2°, and two deviations of 0.3° each."""
    state = watched.first.state.copy()
    state[3] = watched.model.goal_angle + math.radians(degrees)
    seen = replace(watched.first, state=state, angle_deviation=math.radians(0.3))
    assert watched.opening.passed(seen) is there
