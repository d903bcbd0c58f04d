"""How fast a leaf is to go: the profile before the goal, the wanted duration, and what the check says of it."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.feasibility.swing.flight import duration_findings
from doorman.model import Model
from doorman.planning.grip.door_problem import door_cost
from doorman.planning.pace import Pace, duration_held, rate_to_goal
from doorman.scenario import Scenario


@pytest.mark.parametrize("deceleration", [0.01, 0.05, 0.3])
def test_a_leaf_slows_down_by_no_more_than_it_may_and_settles(deceleration: float) -> None:
    way = np.linspace(-0.2, 1.2, 20_001)
    rates = rate_to_goal(way, 0.3, deceleration, 0.6)
    slows = rates * np.gradient(rates, way)
    assert slows.max() < 1.01 * deceleration
    assert 0.0 < rates.max() <= 0.3
    near = rate_to_goal(1e-4, 0.3, deceleration, 0.6)
    assert near == pytest.approx(1e-4 / 0.6, rel=0.1), "it settles with the time constant"
    assert rates[0] < 0.0, "beyond the goal it comes back"


def task(kind: str, duration: float | str) -> Model:
    return Model(Scenario.load(kind, {"goal.duration": duration}))


def test_a_wanted_duration_slows_a_push_down() -> None:
    safe, slow = Pace.of(task("push", "safe")), Pace.of(task("push", 20.0))
    assert slow.rate < 0.5 * safe.rate and slow.acceleration < 0.5 * safe.acceleration
    way = task("push", 20.0).travel.length
    assert slow.duration(way, 0.1) == pytest.approx(20.0, rel=0.15)
    assert Pace.of(task("push", 0.1)) == safe, "and none makes it faster than is safe"


def test_a_wanted_duration_slows_a_grip_down() -> None:
    safe, slow, hasty = (door_cost(task("paper", duration)).state_weights[4] for duration in ("safe", 10.0, 0.1))
    assert slow > 3.5 * safe and hasty == safe


def test_a_heavy_leaf_in_the_gripper_goes_more_slowly() -> None:
    heavy = Model(Scenario.load("paper", {"door.mass": 60.0}))
    assert duration_held(heavy) > 1.2 * duration_held(task("paper", "safe"))


@pytest.mark.parametrize("kind", ["paper", "push"])
def test_the_check_says_which_durations_are_not_possible(kind: str) -> None:
    assert duration_findings(task(kind, "safe")) == []
    (hasty,), (slow,) = (duration_findings(task(kind, duration)) for duration in (2.0, 30.0))
    assert "not possible" in hasty.message and "goal.duration" in hasty.advice
    assert not slow.advice
