"""The push's constraints: derivatives, the physics behind them, and that the door can always be stopped."""

from __future__ import annotations

import math

import numpy as np
import pytest
from paper_door import door_normal, leaf_direction

from doorman.exceptions import DimensionError, ScenarioError
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import GRAVITY, Model
from doorman.ocp.kernels import functions
from doorman.ocp.solvers.solution import PlanStatus
from doorman.planning.hinge import Hinge
from doorman.planning.planner import Plan, Planner
from doorman.planning.push_problem import push_numbers, push_problem, with_hinge
from doorman.planning.quasi_static_planning import push_state
from doorman.scenario import Scenario

RESISTANCE = 0.8


@pytest.fixture(scope="module")
def model() -> Model:
    return Model(Scenario.load("push"))


@pytest.fixture(scope="module")
def planner(model: Model) -> Planner:
    return Planner(model)


def random_pairs(model: Model, count: int):
    generator = np.random.default_rng(7)
    for _ in range(count):
        yield (
            model.start_state + 0.15 * generator.standard_normal(model.nx),
            model.hover_input + 0.3 * generator.standard_normal(model.nu),
        )


N_STATE_ROWS = 8
"""Rows of h beyond the door problem's."""


def numbers_of(model: Model, start: np.ndarray):
    return with_hinge(model, push_numbers(model), Hinge(0.3, -RESISTANCE, model.door.inertia, 0.0, 0.0), start)


def test_slopes_meet_finite_differences(model: Model) -> None:
    problem = push_problem(model, numbers_of(model, model.start_state))
    nh, ng, parameters = problem.n_constraints, problem.n_input_constraints, problem.model
    for x, u in random_pairs(model, 5):
        h, slopes = np.zeros(nh), np.zeros((nh, model.nx))
        functions.linearize_constraints(parameters, x, h, slopes)
        g, mixed = np.zeros(ng), np.zeros((ng, model.nx + model.nu))
        functions.linearize_input_constraints(parameters, x, u, g, mixed)
        point = np.concatenate([x, u])
        for j in range(len(point)):
            rows = []
            for sign in (1.0, -1.0):
                moved = point.copy()
                moved[j] += sign * 1e-6
                ahead, mixed_ahead = np.zeros(nh), np.zeros(ng)
                functions.constrain(parameters, moved[: model.nx], ahead)
                functions.constrain_input(parameters, moved[: model.nx], moved[model.nx :], mixed_ahead)
                rows.append((ahead, mixed_ahead))
            if j < model.nx:
                np.testing.assert_allclose(slopes[:, j], (rows[0][0] - rows[1][0]) / 2e-6, atol=1e-7)
            np.testing.assert_allclose(mixed[:, j], (rows[0][1] - rows[1][1]) / 2e-6, atol=1e-7)


def test_rows_are_the_tips_force_by_newtons_law(model: Model) -> None:
    """Leaf and vehicle each by itself, with the thrust that carries the weight: an independent way to λ."""
    p = numbers_of(model, model.start_state)
    problem, push = push_problem(model, p), model.scenario.push
    lever, mass = model.coupling.distance_from_hinge, model.vehicle.mass
    for x, _ in random_pairs(model, 5):
        rotation = rotation_body_to_world(x[:3])
        rotors = mass * GRAVITY / rotation[2, 2] * rotation[:, 2] - np.array([0.0, 0.0, mass * GRAVITY])
        torque = p.one("door.friction") * math.tanh(x[4] / p.one("door.friction_rate")) - RESISTANCE
        # unknowns α̈ and λ: I_D α̈ = −D_V λ_n − τ;  m (−D_V α̈) = F_n − λ_n along n_D
        acceleration, normal = np.linalg.solve(
            [[model.door.inertia, lever], [-mass * lever, 1.0]], [-torque, door_normal(x[3]) @ rotors]
        )
        sideways = leaf_direction(x[3]) @ rotors + mass * lever * x[4] ** 2
        h = np.zeros(problem.n_constraints)
        functions.constrain(problem.model, x, h)
        rows = h[-N_STATE_ROWS:]
        cone, weight = push.friction_coefficient / math.sqrt(2.0), mass * GRAVITY
        assert rows[1] == pytest.approx(-x[4] - p.one("push.speed"))
        assert rows[2] == pytest.approx((p.one("push.least_force") - normal) / weight)
        assert rows[3] == pytest.approx((sideways - cone * normal) / weight)
        assert rows[4] == pytest.approx((-sideways - cone * normal) / weight)
        assert rows[5] == pytest.approx(-acceleration - p.one("push.acceleration"))
        tip = rotation @ model.vehicle.tip_position(x[5:])
        on_vehicle = -(normal * door_normal(x[3]) + sideways * leaf_direction(x[3]))
        turning = np.cross(tip, on_vehicle)[2]
        assert rows[6] == pytest.approx((turning - model.scenario.push.max_yaw_torque) / weight)
        assert rows[7] == pytest.approx((-turning - model.scenario.push.max_yaw_torque) / weight)


def test_heading_and_arm_keep_step_with_the_door(model: Model, planner: Planner) -> None:
    hinge, state = Hinge(0.5, -1.0, model.door.inertia, 0.0, 0.0), model.start_state.copy()

    def goal(state: np.ndarray) -> np.ndarray:
        return planner.planning.goal(state, hinge)

    np.testing.assert_allclose(goal(model.goal_state), model.goal_state)
    np.testing.assert_allclose(
        goal(state)[[2, 5, 6, 7, 8]], state[[2, 5, 6, 7, 8]], atol=0.1
    )  # but for what the door does within a horizon
    state[3] = 0.5 * (model.start_state[3] + model.goal_state[3])
    half = 0.5 * (model.start_state + model.goal_state)
    np.testing.assert_allclose(goal(state)[[2, 5, 6, 7, 8]], half[[2, 5, 6, 7, 8]], atol=0.1)
    assert goal(state)[3] == model.goal_state[3]


def test_a_margin_keeps_plans_farther_away(model: Model) -> None:
    planner = Planner(model)
    gaps = []
    for margin in (0.0, 0.05):
        planner.update_margin(margin)
        planner.update_door(friction=0.0, disturbance=-RESISTANCE)
        plan = planner.plan(push_state(model, model.start_state, 1.2))
        gaps.append(-model.constraints(plan.states[-1]).max())
    assert gaps[0] > -1e-6 and gaps[1] > 0.05 - 1e-6
    with pytest.raises(DimensionError, match="margin"):
        planner.update_margin(-0.01)


@pytest.mark.parametrize("resistance", [0.2, 0.8, 2.5])
def test_the_least_push_keeps_a_door_stoppable_and_stops_it_before_the_goal(model: Model, resistance: float) -> None:
    """The claim of docs/push.md, by integration from the edge of the set."""
    push, goal = model.scenario.push, float(model.goal_state[3])
    inertia = model.door.inertia + model.vehicle.mass * model.coupling.distance_from_hinge**2
    deceleration = push.stopping_share * resistance / inertia
    angle, rate, step = goal + 0.8, -math.sqrt(2.0 * deceleration * 0.8), 1e-3
    for _ in range(200_000):
        rate = min(rate + step * (1.0 - push.least_share) * resistance / inertia, 0.0)
        angle += step * rate
        assert 0.5 * rate**2 <= deceleration * (angle - goal) + 1e-6
        if rate == 0.0:
            break
    assert rate == 0.0 and angle >= goal


def test_shares_that_cannot_brake_are_refused() -> None:
    with pytest.raises(ScenarioError, match="cannot always be stopped"):
        Scenario.load("push", {"push.least_share": 0.9})


def opening(planner: Planner, seconds: float) -> list[Plan]:
    """Closed loop without noise."""
    model = planner.model
    planner.update_door(friction=0.0, disturbance=-RESISTANCE)
    plan = planner.plan(push_state(model, model.start_state, 1.2))
    plans = [plan]
    for _ in range(round(seconds / plan.time_step)):
        plan = planner.replan(plan.states[1])
        plans.append(plan)
    return plans


def test_plans_press_all_the_way_and_stop_at_the_goal(planner: Planner) -> None:
    push = planner.model.scenario.push
    plans = opening(planner, 20.0)
    for plan in plans:
        assert plan.usable, plan.violated
        assert planner.normal_forces(plan).min() > 0.0
        assert plan.states[:, 4].min() > -push.max_rate - 2e-3
    angles = np.array([plan.states[0, 3] for plan in plans])
    assert math.degrees(angles[-1]) == pytest.approx(20.0, abs=1.0)
    assert math.degrees(angles.min()) > 19.0


def test_a_start_that_is_too_fast_is_planned_and_said(planner: Planner) -> None:
    model = planner.model
    planner.update_door(friction=0.0, disturbance=-RESISTANCE)
    start = push_state(model, model.start_state, 0.8)
    start[4] = -0.3
    plan = planner.plan(start)
    assert plan.status is PlanStatus.RELAXED
    assert plan.usable and plan.flyable
    assert plan.states[-1, 4] > -0.3  # it is being braked, by the door itself
    assert planner.normal_forces(plan).min() > 0.0


def test_a_door_that_wind_opens_is_planned_and_said(planner: Planner) -> None:
    """It gets faster under the least push, and the plan cannot help it: the rest of the constraints holds."""
    model = planner.model
    for opening, rate in ((0.1, -0.05), (0.5, -0.1), (1.0, -0.25)):
        planner.update_door(friction=0.3, disturbance=0.3 + opening)
        start = push_state(model, model.start_state, 0.2)
        start[3:5] = start[3] - 0.05, rate
        plan = planner.plan(start)
        assert plan.status is PlanStatus.RELAXED, plan.violated
        assert plan.states[-1, 4] < rate - 0.01
        assert planner.normal_forces(plan)[1:].min() > 0.0
        assert model.constraints_along(plan.states[1:]).max() <= 1e-6
    standing = push_state(model, model.start_state, 0.2)
    planner.update_door(friction=0.3, disturbance=0.0)
    assert planner.plan(standing).status is PlanStatus.CONVERGED
    planner.update_door(friction=0.3, disturbance=0.8)
    refused = planner.plan(standing)
    assert refused.status is PlanStatus.CANNOT_STOP, "it is not set in motion"
    assert not refused.flyable and refused.cost == math.inf
    assert refused.violated.startswith("resists by -0.50 N m; the least push, 0.10 N, makes 0.07 N m")


def test_planned_motion_is_that_of_vehicle_and_leaf_together(planner: Planner) -> None:
    """One step with the plan's own force balance: I_e, not I_D."""
    model = planner.model
    numbers = numbers_of(model, model.start_state).replaced({"door.disturbance": 0.0, "door.friction": 0.0})
    x = push_state(model, model.start_state, 2.0)
    out = np.empty(model.nx)
    functions.step(push_problem(model, numbers).model, x, model.hover_input.copy(), out)
    inertia = model.door.inertia + model.vehicle.mass * model.coupling.distance_from_hinge**2
    force = model.hover_input[0] * (door_normal(x[3]) @ rotation_body_to_world(x[:3])[:, 2])
    expected = -model.coupling.distance_from_hinge * force / inertia * model.scenario.planner.time_step
    assert out[4] == pytest.approx(expected, rel=1e-3)


def test_full_dynamics_refuse_a_tip_that_can_only_push() -> None:
    with pytest.raises(ScenarioError, match="planner.model"):
        Planner(Scenario.load("push", {"planner.model": "lagrangian"}))
