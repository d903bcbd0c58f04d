"""What ends an attempt at the leaf: rotors near a jamb, a vehicle that sinks, a leaf beyond the goal."""

from __future__ import annotations

import math

import numpy as np
import pytest
from believed import changed

from doorman import Planner
from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate, Estimator, Tie
from doorman.control.state_converter import StateConverter
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.guard import Guard
from doorman.mission.phases.hold import Hold
from doorman.mission.phases.open import Open
from doorman.mission.phases.phase import GiveUp
from doorman.mission.schedule import PlanSchedule
from doorman.recording import Recorder
from doorman.signals import Measurement

TICK = 0.01
UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def planner() -> Planner:
    return Planner("push")


class AtTheLeaf:
    """An attempt that has just touched, and its guard."""

    def __init__(self, planner: Planner) -> None:
        self.model, rest = planner.model, np.zeros(3)
        converter = StateConverter(self.model)
        estimator = Estimator(self.model)
        self.attempt = Attempt(self.model, converter, PlanSchedule(planner, 0, Recorder(None, {})), estimator)
        attitude, arm = self.model.start_state[:3], self.model.start_arm
        place = self.model.coupling.vehicle_position(attitude, self.model.start_angle, arm)
        seen = Measurement(0.0, place, rest, attitude, rest, arm, np.zeros(self.model.n_arm), 0.0)
        self.known: Estimate = estimator.update(seen, Tie.PUSHING, False, 0.0)
        self.guard, self.time = Guard(self.attempt), 0.0
        self.phase = Open(self.attempt, self.known, None)
        self.guard.begin(0.0)
        assert self.judged(seconds=0.1) is None

    def judged(
        self, moved: Array | float = 0.0, seconds: float = 0.3, door_angle: float | None = None
    ) -> GiveUp | None:
        """Verdict on a vehicle that has been elsewhere for a while, or on a leaf that is."""
        state = self.known.state.copy()
        state[3] = state[3] if door_angle is None else door_angle
        for _ in range(round(seconds / TICK)):
            self.time += TICK
            place = self.known.position + moved
            seen = changed(self.model, self.known, time=self.time, position=place, state=state)
            if verdict := self.guard.judge(self.phase, seen):
                return verdict
        return None


@pytest.fixture
def there(planner: Planner) -> AtTheLeaf:
    return AtTheLeaf(planner)


def test_a_vehicle_that_sinks_gives_up(there: AtTheLeaf) -> None:
    assert there.judged(0.12 * UP, seconds=1.0) is None, "it has risen"
    assert there.judged(-0.08 * UP, seconds=1.0) is None, "no farther than plans may lower it"
    verdict = there.judged(-0.12 * UP)
    assert verdict is not None and verdict.reason.startswith("the vehicle has sunk by 12 cm at ")


def test_a_vehicle_that_sinks_for_a_moment_goes_on(there: AtTheLeaf) -> None:
    for _ in range(5):
        assert there.judged(-0.12 * UP, seconds=0.06) is None
        assert there.judged(seconds=0.02) is None


def test_another_attempt_may_touch_lower(there: AtTheLeaf) -> None:
    there.attempt.begin_anew()
    assert there.judged(-0.12 * UP) is None


def test_a_leaf_beyond_the_goal_ends_a_push(there: AtTheLeaf) -> None:
    travel = there.model.travel
    for share, ends in ((0.0, False), (0.5, False), (1.0, False)):
        assert (there.judged(door_angle=travel.start + share * (travel.goal - travel.start)) is not None) is ends
    assert there.judged(door_angle=travel.goal + travel.sense * math.radians(5.0)) is None
    verdict = there.judged(door_angle=travel.goal + travel.sense * math.radians(12.0))
    assert verdict is not None and verdict.reason.startswith("the leaf has gone past the goal")


def test_rotors_that_come_to_a_jamb_end_the_attempt(there: AtTheLeaf) -> None:
    """Beside an open leaf, in the doorway."""
    model, door = there.model, there.model.door
    place = model.coupling.vehicle_position(model.goal_state[:3], model.goal_angle, model.goal_arm)
    into = door.into * (door.into @ (door.hinge_position - place))
    there.known = changed(model, there.known, position=place + into, state=model.goal_state, arm_angles=model.goal_arm)
    there.attempt.begin_anew()
    room = door.width - float(door.along @ (place - door.hinge_position)) - model.vehicle.radius
    aside = (room + 0.01) * door.along
    assert there.judged((room - 0.05) * door.along) is None
    assert there.judged(aside, seconds=0.08) is None, "a gap in the poses moves a jamb by centimetres"
    assert there.judged((room - 0.05) * door.along) is None
    verdict = there.judged(aside)
    assert verdict is not None and verdict.at_once and "come too near to a jamb" in verdict.reason


def test_a_held_door_counts_once_it_has_rested_at_the_goal_for_long_enough(there: AtTheLeaf) -> None:
    """A leaf that is drawn back and stands for a moment may go on: only `hold_open` of rest ends the mission."""
    there.attempt.opening.update(there.known)
    hold, state = Hold(there.attempt, there.known, None), there.known.state.copy()
    state[3] = there.model.goal_angle
    long = there.model.scenario.mission.hold_open

    def held(until: float, rests: bool) -> float | None:
        """When the phase ends before that, of a leaf that rests or creeps."""
        while there.time < until:
            there.time += TICK
            seen = changed(there.model, there.known, time=there.time, state=state, rests=rests)
            if hold.step(seen, np.zeros(3), TICK)[1] is not None:
                return there.time
        return None

    began = there.time
    assert held(began + 1.5 * long, rests=False) is None
    stands = there.time
    assert held(stands + 2.0 * long, rests=True) == pytest.approx(stands + long, abs=3 * TICK)
