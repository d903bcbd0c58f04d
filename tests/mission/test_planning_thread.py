"""Planning in a thread of its own: the controller never waits, and hears of everything that comes of it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import pytest

from doorman import Model, Planner, Scenario
from doorman.control.wanted import Wanted
from doorman.exceptions import DoormanError
from doorman.mission.schedule import PlanSchedule
from doorman.planning.hinge import Hinge
from doorman.recording import Recorder

PATIENCE = 30.0


@pytest.fixture(scope="module")
def model() -> Model:
    return Model(Scenario.load("paper", {"mission.start": "contact"}))


class HeldPlanner(Planner):
    """A planner that begins a plan when it is let."""

    def __init__(self, model: Model) -> None:
        super().__init__(model)
        self.let, self.threads, self.error = threading.Semaphore(0), [], ""

    def plan(self, state, **options):
        self._wait()
        return super().plan(state, **options)

    def replan(self, state, elapsed=None, **options):
        self._wait()
        return super().replan(state, elapsed, **options)

    def _wait(self) -> None:
        assert self.let.acquire(timeout=PATIENCE)
        self.threads.append(threading.current_thread())
        if self.error:
            raise DoormanError(self.error)


@pytest.fixture
def schedule(model: Model):
    made = PlanSchedule(HeldPlanner(model), 1, Recorder(None, {}))
    with made.running(in_background=True):
        yield made
        made.planner.let.release(100)


@pytest.fixture
def wanted(model: Model) -> Callable[[], Wanted]:
    """At a hinge that resists little."""
    return lambda: Wanted(model.start_state, Hinge(0.0, -0.3, 5.0, 0.0, 0.0))


def answered(schedule: PlanSchedule) -> None:
    """Let the planner make a plan."""
    schedule.planner.let.release()
    end = time.monotonic() + PATIENCE
    while schedule._thread._order is not None:
        assert time.monotonic() < end
        time.sleep(0.001)


def test_the_controller_goes_on_while_a_plan_is_made(schedule: PlanSchedule, wanted) -> None:
    for k in range(20):  # would wait for ever if it waited at all
        assert schedule.update(0.005 * k, wanted) is None
    assert schedule.overdue(0.095) == pytest.approx(0.095)
    answered(schedule)
    current = schedule.update(0.1, wanted)
    assert current is not None and (current.start, current.available_at) == (0.0, 0.1)
    for k in range(21, 40):
        assert schedule.update(0.005 * k, wanted) is current
    answered(schedule)
    newer = schedule.update(0.2, wanted)
    assert newer is not None and newer.start == pytest.approx(0.1), "begun at the tick at which the first one came"
    assert set(schedule.planner.threads) == {schedule._thread._thread}
    assert schedule.recorder.recording()["plan"]["cold"].tolist() == [True, False]


def test_a_plan_from_before_it_forgot_is_not_followed(schedule: PlanSchedule, wanted) -> None:
    schedule.update(0.0, wanted)
    schedule.forget()
    answered(schedule)
    assert schedule.update(0.01, wanted) is None
    answered(schedule)
    current = schedule.update(0.02, wanted)
    assert current is not None and current.start == pytest.approx(0.01)
    assert schedule.recorder.recording()["plan"]["cold"].tolist() == [True, True]


def test_what_the_planner_raises_the_controller_hears(schedule: PlanSchedule, wanted) -> None:
    schedule.planner.error = "made up"
    schedule.update(0.0, wanted)
    answered(schedule)
    with pytest.raises(DoormanError, match="made up"):
        schedule.update(0.005, wanted)


def test_plans_are_the_same_in_either_thread(model: Model, schedule: PlanSchedule, wanted) -> None:
    here = PlanSchedule(Planner(model), 0, Recorder(None, {}))
    for k in range(4):
        schedule.update(0.01 * k, wanted)
        answered(schedule)
        here.update(0.01 * k, wanted)
    schedule.update(0.04, wanted)
    made, alike = (one.recorder.recording()["plan"]["states"] for one in (schedule, here))
    assert (made == alike).all()


def test_a_silent_planner_is_noticed(schedule: PlanSchedule, wanted) -> None:
    schedule.update(0.0, wanted)
    assert not schedule.is_silent(0.4) and schedule.is_silent(0.6)
