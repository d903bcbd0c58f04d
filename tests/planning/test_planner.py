"""Receding horizon: cold and warm plans along a motion, misuse, and arms of other lengths."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest
from door_tasks import model_of, planner_of, start_state

from doorman import Model, Plan, Planner, PlanStatus, Scenario
from doorman.exceptions import DimensionError, SingularityError
from doorman.gravity import GRAVITY
from doorman.planning.grip.push import push_state
from doorman.planning.hinge import Hinge
from doorman.scenario import PlannerSection


@pytest.fixture
def fresh() -> Callable[[str], Planner]:
    return lambda name: Planner(model_of(name))


def assert_holds(model: Model, plan: Plan, state: np.ndarray) -> None:
    """The plan starts at the state, obeys the dynamics and keeps the constraints."""
    assert plan.usable
    np.testing.assert_array_equal(plan.states[0], state)
    for x, u, after in zip(plan.states, plan.inputs, plan.states[1:], strict=False):
        np.testing.assert_allclose(model.step(x, u), after, atol=1e-12)
    assert (model.constraints_along(plan.states[1:]) + model.scenario.planner.margin).max() <= 1e-6


@pytest.mark.parametrize("name", ["coarse", "heavy"])
@pytest.mark.parametrize("elapsed", [None, "time step"])
def test_replans_along_the_motion_stay_near_the_optimum(fresh, name: str, elapsed: str | None) -> None:
    """100 steps, one iteration each; compared with a cold plan, run to convergence."""
    planner, judge = fresh(name), planner_of(name)
    model, dt = planner.model, planner.settings.time_step
    assert planner.settings.iterations == 1
    state = model.start_state
    plan = planner.plan(state)
    opened = []
    for k in range(100):
        state = model.step(state, plan.inputs[0])
        plan = planner.replan(state, elapsed=None if elapsed is None else dt)
        assert 1 <= plan.iterations <= 4  # more than one only where the step was large
        optimum = judge.plan(state)
        assert optimum.status is PlanStatus.CONVERGED
        assert plan.cost == pytest.approx(optimum.cost, rel=1e-4)
        assert plan.cost >= optimum.cost * (1.0 - 1e-7)
        if k % 10 == 0:
            assert_holds(model, plan, state)
        opened.append(state[3])
    assert (np.diff(opened) < 0.0).all()
    assert opened[-1] < 1.0


def test_replans_from_disturbed_states_hold_and_stay_near_the_optimum(fresh, rng: np.random.Generator) -> None:
    """Noise on every state and a look-ahead that the planner has to find by itself."""
    planner, judge = fresh("margin"), planner_of("margin")
    model = planner.model
    state = model.start_state
    plan = planner.plan(state)
    losses = []
    for _ in range(60):
        state = model.step(state, plan.inputs[0]) + 2e-3 * rng.normal(size=9)
        plan = planner.replan(state)
        assert_holds(model, plan, state)
        losses.append(plan.cost / judge.plan(state).cost - 1.0)
    assert max(losses) < 2e-2
    assert np.median(losses) < 1e-4


@pytest.mark.parametrize("kind", ["quasi_static", "whole_body", pytest.param("lagrangian", marks=pytest.mark.slow)])
def test_a_gripped_door_is_brought_to_another_goal(kind: str) -> None:
    planner = Planner(Scenario.load("paper", {"planner.model": kind}))
    model, goal = planner.model, planner.planning.goal_state
    planner.update_goal(model.start_angle)
    back = planner.plan(goal)
    assert back.flyable
    reduced, _ = planner.planning.reduced(back.states, back.inputs)
    assert reduced[-1, 3] > model.goal_angle + 0.1
    assert reduced[-1, 2] > reduced[0, 2], "the heading keeps step"
    planner.update_goal(None)
    assert planner.plan(goal).cost < 0.01 * back.cost, "it is there already"


def test_goals_that_are_none_are_refused(fresh) -> None:
    with pytest.raises(DimensionError, match="door_angle"):
        fresh("paper").update_goal(math.nan)


def test_more_iterations_come_nearer(monkeypatch: pytest.MonkeyPatch) -> None:
    losses = []
    for iterations in (1, 4):
        monkeypatch.setattr(PlannerSection, "iterations", iterations)
        planner = Planner("paper")
        state = planner.plan(planner.model.start_state).states[3] + 0.02
        replanned = planner.replan(state, elapsed=0.06)
        assert iterations <= replanned.iterations <= iterations + 3  # more only where the step was large
        assert planner.replan(state, elapsed=0.0, max_iterations=1).iterations == 1
        losses.append(replanned.cost / planner.plan(state).cost - 1.0)
    assert losses[0] < 1e-4
    assert losses[1] < min(losses[0], 1e-6)


def test_replan_without_a_previous_plan_is_cold(fresh) -> None:
    state = start_state("paper", "thrown")
    cold, replanned = fresh("paper").plan(state), fresh("paper").replan(state, elapsed=0.1)
    np.testing.assert_array_equal(cold.states, replanned.states)
    assert replanned.status is PlanStatus.CONVERGED
    assert replanned.iterations == cold.iterations > 1


def test_a_jump_of_the_state_is_planned_anew(fresh) -> None:
    planner = fresh("paper")
    planner.plan(model_of("paper").start_state)
    state = start_state("paper", "late")
    plan = planner.replan(state)
    assert_holds(model_of("paper"), plan, state)
    for _ in range(8):
        plan = planner.replan(state, elapsed=0.0)
    assert plan.cost == pytest.approx(planner_of("paper").plan(state).cost, rel=1e-6)


def test_a_plan_that_is_not_usable_says_so_and_is_forgotten(fresh) -> None:
    planner, model = fresh("paper"), model_of("paper")
    planner.plan(model.start_state)
    flying = model.start_state.copy()
    flying[4] = 1e9
    for plan in (planner.plan(flying), planner.replan(flying)):
        assert plan.status is PlanStatus.DIVERGED
        assert not plan.usable and not plan.flyable
        assert plan.cost == math.inf
        assert plan.max_violation > 1e-3
    back = planner.replan(model.start_state)
    np.testing.assert_array_equal(back.states, fresh("paper").plan(model.start_state).states)


def test_a_plan_cannot_be_written_to_and_keeps_its_numbers(fresh) -> None:
    planner = fresh("paper")
    plan = planner.plan(start_state("paper", "active"))
    assert plan.solve_time > 0.0
    assert plan.time_step == 0.02
    for array in (plan.states, plan.inputs):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        plan.cost = 0.0  # type: ignore[misc]
    kept = plan.states.copy()
    planner.replan(plan.states[1])
    np.testing.assert_array_equal(plan.states, kept)


@pytest.mark.parametrize("method", ["plan", "replan"])
def test_what_is_not_a_state_is_an_error(fresh, method: str) -> None:
    planner, start = fresh("paper"), model_of("paper").start_state
    planner.plan(start)
    call = getattr(planner, method)
    with pytest.raises(DimensionError, match="state"):
        call(start[:8])
    for pitch in (math.pi / 2, -math.pi / 2, 2.0):
        upright = start.copy()
        upright[1] = pitch
        with pytest.raises(SingularityError, match="pitch"):
            call(upright)
    assert planner.replan(start).usable


@pytest.mark.parametrize("elapsed", [-1.0, 0.0, 1.0, 50.0])
def test_times_beyond_the_plan_are_its_ends(fresh, elapsed: float) -> None:
    planner, start = fresh("paper"), model_of("paper").start_state
    planner.plan(start)
    assert_holds(model_of("paper"), planner.replan(start, elapsed=elapsed), start)


def test_update_door_changes_the_plan_and_back(fresh) -> None:
    planner, start = fresh("paper"), model_of("paper").start_state
    before = planner.plan(start)
    planner.update_door(disturbance=-2.0)
    braked = planner.plan(start)
    planner.update_door(friction=0.5)
    rubbing = planner.plan(start)
    assert before.cost < braked.cost < rubbing.cost
    told = Planner(Scenario.load("paper", {"planner.margin": 0.0, "door.friction": 0.5}))
    told.update_door(disturbance=-2.0)
    np.testing.assert_allclose(told.plan(start).states, rubbing.states, atol=1e-9)
    planner.update_door(friction=0.0, disturbance=0.0)
    np.testing.assert_array_equal(planner.plan(start).states, before.states)
    assert planner.model.door.friction == 0.0


def test_plans_lean_against_what_the_door_resists_with(fresh) -> None:
    """At the attitude that the cost draws to, the door neither gains nor loses speed."""
    planner, model = fresh("paper"), model_of("paper")
    resisting = Hinge(0.0, -1.0, model.door.inertia, 0.0, 0.8)
    leaning = planner.planning.goal(model.start_state, resisting)
    reduced = model.reduced.with_numbers({**resisting.numbers(), "door.moving_inertia": resisting.inertia})
    thrust = model.vehicle.mass * GRAVITY / (math.cos(leaning[0]) * math.cos(leaning[1]))
    after = reduced.step(leaning, np.array([thrust, *np.zeros(3 + model.n_arm)]))
    assert after[4] == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_array_equal(planner.planning.goal(model.start_state, Hinge.of(model.door)), model.goal_state)


@pytest.mark.parametrize(("name", "stiffness"), [("paper", 0.0), ("push", 0.9)])
def test_estimates_are_the_plan_s_as_if_the_scenario_named_them(name: str, stiffness: float) -> None:
    """A closer apart with a grip: its goal leans against what the scenario does not name."""
    hinge = {"damping": 0.6, "friction": 0.4, "stiffness": stiffness}
    told = Planner(Scenario.load(name, {f"door.{key}": value for key, value in hinge.items()}))
    plain = Planner(Scenario.load(name))
    start = told.planning.state(push_state(told.model, told.model.start_state, 1.0), np.zeros(3))
    without = plain.plan(start)
    plain.update_door(**hinge)
    first, second = told.plan(start), plain.plan(start)
    assert first.usable and np.abs(first.states - without.states).max() > 1e-3
    np.testing.assert_allclose(first.states, second.states, atol=1e-9)


@pytest.mark.parametrize("name", ["paper", "push"])
def test_a_door_that_nobody_can_push_is_said_with_numbers(name: str) -> None:
    planner = Planner(Scenario.load(name))
    model, start = planner.model, planner.planning.start_state
    push = model.vehicle.mass * GRAVITY * math.tan(model.scenario.control.max_tilt)
    most = push * model.coupling.distance_from_hinge
    planner.update_door(friction=0.0, disturbance=-1.01 * most)
    for plan in (planner.plan(start), planner.replan(start)):
        assert plan.status is PlanStatus.CANNOT_OPEN and not plan.flyable
        assert f"resists with {1.01 * most:.2f} N m" in plan.violated and f"makes {most:.2f} N m" in plan.violated
    planner.update_door(disturbance=0.0, stiffness=1.01 * most / (math.pi / 2 - math.pi / 9 - 0.05))
    assert planner.plan(start).status is PlanStatus.CANNOT_OPEN, "the closer wins on the way"
    planner.update_door(disturbance=-0.5, stiffness=0.0)
    assert planner.plan(start).flyable


def test_hinges_that_cannot_be_are_errors_and_change_nothing(fresh) -> None:
    planner, start = fresh("paper"), model_of("paper").start_state
    before = planner.plan(start)
    for name in ("friction", "damping", "stiffness", "inertia", "disturbance"):
        for value in (math.nan, math.inf, *[-0.1] * (name != "disturbance"), *[0.0] * (name == "inertia")):
            with pytest.raises(DimensionError) as caught:
                planner.update_door(**{name: value})
            assert caught.value.field == name
    np.testing.assert_array_equal(planner.plan(start).states, before.states)


@pytest.mark.parametrize("limit", [1e-5, 1e-4, 2e-4, 3e-4])
def test_time_that_ends_early_keeps_what_was_found(limit: float, fresh) -> None:
    planner = fresh("paper")
    state, spare = planner.model.start_state, 1e-6
    first = planner.plan(state, max_iterations=1)
    plan = planner.plan(state, time_limit=limit)
    assert plan.usable
    assert plan.cost <= first.cost + spare
