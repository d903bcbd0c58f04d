"""The whole body behind the planner's interface: states, forces, references, and a plan that opens a door."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman import Model, Planner, Scenario
from doorman.collision.rows.plane import LEAF
from doorman.exceptions import DimensionError, ScenarioError, SingularityError
from doorman.planning.hinge import Hinge
from doorman.planning.planning_model import planning_model
from doorman.planning.whole_body.contact import depth_of, depths_in_face, tip_on_face

PUSH = Scenario.load("push")


@pytest.fixture(scope="module")
def planner() -> Planner:
    return Planner(PUSH)


def test_a_reduced_state_comes_back_from_the_whole_one(planner: Planner) -> None:
    model, planning = planner.model, planner.planning
    reduced = model.on_the_way(1.1) + 0.05
    omega = np.array([0.1, -0.2, 0.3])
    x = planning.state(reduced, omega)
    assert len(x) == len(planning.state_names)
    states, inputs = planning.reduced(x, np.zeros(len(planning.input_names)))
    np.testing.assert_allclose(states, reduced, atol=1e-12)
    np.testing.assert_allclose(inputs[1:4], omega, atol=1e-12)


def test_a_state_that_is_refused_is_named_by_its_place(planner: Planner) -> None:
    planning = planner.planning
    upright, unknown = planning.start_state.copy(), planning.start_state.copy()
    upright[4], unknown[7] = math.pi / 2, math.nan
    with pytest.raises(SingularityError, match=r"state\[4\]"):
        planning.check_state(upright)
    with pytest.raises(DimensionError, match=r"state\[7\]"):
        planning.check_state(unknown)


def test_the_force_of_a_state_at_the_leaf_is_that_of_the_contacts_spring(planner: Planner) -> None:
    planning, model = planner.planning, planner.model
    x = planning.state(model.on_the_way(1.0), np.zeros(3))
    deeper = x.copy()
    deeper[:3] += 1e-3 * model.door.normal(1.0)
    forces = planning.normal_forces(planning.numbers, np.array([x, deeper, x]), np.zeros((2, 8)))
    assert forces[0] == pytest.approx(0.5, abs=1e-6)
    depths = [depth_of(float(force), planning.numbers) for force in forces]
    assert len(forces) == 2 and depths[1] - depths[0] == pytest.approx(1e-3, abs=1e-7)


def test_the_numbers_that_fit_a_hinge_are_that_hinges(planner: Planner) -> None:
    hinge = Hinge(0.3, -0.7, 4.0, 0.2, 0.9)
    numbers = planner.planning.fitted(hinge, 0.05, planner.planning.start_state)
    named = {"friction": 0.3, "disturbance": -0.7, "inertia": 4.0, "damping": 0.2, "stiffness": 0.9}
    assert {name: numbers.one(f"door.{name}") for name in named} == named
    assert numbers.one("limits.margin") == 0.05
    assert numbers.one("reference.force") > 0.9 / 0.75  # it pushes against what resists


def test_what_resists_does_so_beyond_the_goal_as_well(planner: Planner) -> None:
    planning, model, hinge = planner.planning, planner.model, Hinge(0.0, -0.7, 4.0, 0.0, 0.0)
    for off in (0.01, -0.01):
        start = planning.state(model.on_the_way(model.goal_angle + off), np.zeros(3))
        assert planning.fitted(hinge, 0.05, start).one("reference.force") > 0.3


def test_given_numbers_replace_what_would_fit_whether_some_or_all_are_given(planner: Planner) -> None:
    planning, hinge, start = planner.planning, Hinge(0.3, -0.7, 4.0, 0.2, 0.9), planner.planning.start_state
    fits = planning.fitted(hinge, 0.05, start)
    every = {name: 1.5 * fits[name] + 0.1 for name in fits.sizes if name != "limits.margin"}
    for given in ({"reference.force": 7.0}, every):
        found = planning.fitted(hinge, 0.05, start, given)
        np.testing.assert_array_equal(found.vector, fits.replaced(given).vector)


def test_given_numbers_hold_until_others_are_given(planner: Planner) -> None:
    planner.update_numbers({"vehicle.wind": [0.0, 1.0, 0.0]})
    first = planner.plan(planner.planning.start_state)
    assert planner.numbers["vehicle.wind"][1] == 1.0
    planner.update_numbers({})
    second = planner.plan(planner.planning.start_state)
    assert planner.numbers["vehicle.wind"][1] == 0.0
    assert np.abs(first.inputs - second.inputs).max() > 1e-2
    with pytest.raises(DimensionError, match="no such number"):
        planner.update_numbers({"vehicle.wings": 2.0})


def test_plan_after_plan_opens_the_door_and_rests_at_the_goal(planner: Planner) -> None:
    planner.update_door(friction=0.0, disturbance=-0.6)  # a smooth friction would let the leaf creep on
    x, rates = planner.planning.start_state, []
    plan = planner.plan(x)
    for _ in range(1300):
        x = plan.states[1].copy()
        rates.append(-x[13])
        plan = planner.replan(x, 0.02, max_iterations=1)
        assert plan.flyable
    goal = planner.model.goal_angle
    assert (
        x[12] == pytest.approx(goal, abs=math.radians(2.0))
        and max(rates) < 1.05 * planner.numbers.one("reference.opening_speed")
        and abs(rates[-1]) < 5e-3
    )
    planner.update_door(friction=planner.model.door.friction, disturbance=0.0)


def test_plans_ask_for_no_more_than_the_limits_of_the_scenario() -> None:
    limits = {"limits.joint_rates": 0.4, "limits.tilt": 0.2}
    bounds = planning_model(Model(Scenario.load("push", limits))).problem().bounds
    lower, upper = np.asarray(bounds.input_lower), np.asarray(bounds.input_upper)
    assert upper[1] == upper[2] == 0.2 and (upper[4:] == 0.4).all() and (lower[4:] == -0.4).all()
    free = planning_model(Model(Scenario.load("push", {**limits, "limits.enabled": False}))).problem().bounds
    assert np.asarray(free.input_upper)[1] == Scenario.load("push").control.max_tilt


@pytest.mark.parametrize(
    ("name", "given"),
    [("push", "quasi_static"), *((name, "lagrangian") for name in ("push", "drawer", "sliding", "hatch"))],
)
def test_a_task_that_a_model_does_not_plan_is_refused(name: str, given: str) -> None:
    """The paper's models hold on to the door, and the full dynamics are those of a vertical hinge."""
    with pytest.raises(ScenarioError) as caught:
        planning_model(Model(Scenario.load(name, {"planner.model": given})))
    assert (caught.value.field, caught.value.given) == ("planner.model", given) and caught.value.allowed


def beside_the_leaf(planner: Planner, gap: float) -> np.ndarray:
    """At rest, the arm drawn in, with so much air between rotor disc and leaf."""
    x, door = planner.start_state.copy(), planner.model.door
    x[14:] = [0.0, -0.5, 0.0, 0.0]
    before = door.normal(float(x[12])) @ (planner.model.coupling.contact_point(float(x[12])) - x[:3])
    x[:3] += (before - planner.model.vehicle.radius - gap) * door.normal(float(x[12]))
    return x


def test_the_margin_of_the_disc_is_soft_and_its_limit_hard(planner: Planner) -> None:
    """A start within the margin is no violation, and is left; one that has the disc in the leaf is as much as it is deep."""
    normal = planner.model.door.normal(planner.model.start_angle)
    near = beside_the_leaf(planner, 0.01)
    try:
        planner.update_margin(0.01)
        small = planner.plan(near)
        planner.update_margin(0.2)
        large = planner.plan(near)
    finally:
        planner.update_margin(planner.settings.margin)
    assert small.usable and large.usable and large.violated == "" and large.max_violation <= 1e-6
    assert (small.states[-1, :3] - large.states[-1, :3]) @ normal > 0.02
    deep = planner.plan(beside_the_leaf(planner, -0.02))
    assert not deep.usable and deep.violated.startswith(LEAF) and 0.015 < deep.max_violation < 0.025


def test_no_plan_presses_harder_than_the_vehicle_is_allowed_to(planner: Planner) -> None:
    drawn = {"reference.force": 8.0, "weights.force": 20.0}
    planner.update_numbers(drawn)
    free = planner.normal_forces(planner.plan(planner.start_state))
    planner.update_numbers({**drawn, "limits.force": 3.0})
    plan = planner.plan(planner.start_state)
    held = planner.normal_forces(plan)
    planner.update_numbers({})
    assert free.max() > 4.0 and plan.usable and 2.5 < held.max() < 3.1
    narrow = Model(Scenario.load("push", {"control.max_push": 3.0}))
    assert planning_model(narrow).numbers.one("limits.force") == 3.0


@pytest.mark.parametrize("name", ["push", "hatch", "sliding"])
def test_depths_of_many_states_are_those_of_each_on_any_leaf(name: str) -> None:
    model, rng = Model(name), np.random.default_rng(2)
    start = model.start_state
    positions = model.hover_offset + rng.uniform(-1.0, 1.0, (5, 3))
    attitudes, angles = rng.uniform(-0.5, 0.5, (5, 3)), rng.uniform(0.2, 1.8, 5)
    arms = start[5:] + rng.uniform(-0.5, 0.5, (5, model.n_arm))
    tips = positions + model.coupling.tips(attitudes, arms)
    expected = [
        tip_on_face(tip - model.coupling.contact_point(angle), model.door.normal(angle), *model.door.face(angle))[0]
        for tip, angle in zip(tips, angles.tolist(), strict=True)
    ]
    np.testing.assert_allclose(depths_in_face(model, positions, attitudes, angles, arms), expected, atol=1e-12)


def test_noisy_states_are_followed_without_aiming_anew() -> None:
    planner, rng = Planner(PUSH), np.random.default_rng(5)
    step = 0.01
    plan = planner.plan(planner.planning.start_state)
    deviations = np.concatenate([[1e-3] * 3, [4e-3] * 3, [0.01] * 3, [0.03] * 3, [1e-3, 0.01], [1e-3] * 4])
    iterations = []
    for _ in range(150):
        now = plan.states[0] + (plan.states[1] - plan.states[0]) * step / plan.time_step
        plan = planner.replan(now + deviations * rng.normal(size=now.size), step)
        assert plan.usable, plan.violated
        iterations.append(plan.iterations)
    assert sorted(iterations)[-2] <= 6, iterations
