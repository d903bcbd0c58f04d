"""Plans of a vehicle whose arm has mass: the centre of mass in the whole body's motion, and the bound on the static moment."""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np
import pinocchio
import pytest
from urdf_variants import write_massive

from doorman import Model, Plan, Planner, PlanStatus, Scenario
from doorman.kinematics.rotations import body_rates_of, rotation_body_to_world
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.kinematics.vehicles.balance import balance_of
from doorman.planning.grip.door_problem import door_numbers, quasi_static
from doorman.planning.whole_body.numbers import whole_body_numbers, yaw_inertia
from doorman.planning.whole_body.rows import constraints
from doorman.planning.whole_body.task import WholeBodyTask

SHARES = {"servo_1": 0.2, "servo_2": 0.2, "servo_3": 0.25, "servo_4": 0.35}
"""Of the arm's mass."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("urdf")


def massive(folder: Path, task: str, mass: float = 0.6, **overrides: object) -> Model:
    urdf = write_massive(folder / f"{mass}.urdf", {link: mass * share for link, share in SHARES.items()})
    named = {key.replace("__", "."): value for key, value in overrides.items()}
    return Model(Scenario.load(task, {"vehicle.urdf": str(urdf), **named}))


def symbols(model: Model) -> WholeBodyTask:
    pattern, _ = ArmPattern.of(model.vehicle.arm)
    return WholeBodyTask(pattern, model.vehicle.point_names, whole_body_numbers(model))


def random_state(model: Model, rng: np.random.Generator) -> np.ndarray:
    """Near the leaf, with all rates."""
    attitude, rates, arm = rng.uniform(-0.3, 0.3, 3), rng.normal(size=6), model.start_arm + rng.uniform(-0.2, 0.2, 4)
    return np.concatenate([[-0.5, 0.7, 1.2], attitude, rates, [1.2, -0.1], arm])


def test_the_origin_accelerates_as_pinocchios_does(folder: Path, rng: np.random.Generator) -> None:
    """Inverse dynamics of the plan's accelerations leave the thrust, the wind and the leaf's force, and no other force."""
    model = massive(folder, "push")
    task, numbers = symbols(model), whole_body_numbers(model).replaced({"vehicle.wind": [0.7, -0.4, 0.2]})
    both = ca.vertcat(task.rates_of_change, task.force)
    function = ca.Function("f", [task.state, task.inputs, task.parameters], [both])
    free = pinocchio.buildModelFromUrdf(str(model.vehicle.urdf), pinocchio.JointModelFreeFlyer())
    for _ in range(10):
        x = random_state(model, rng)
        u = np.concatenate([[rng.uniform(25.0, 45.0)], rng.uniform(-0.3, 0.3, 2), [0.1], np.zeros(4)])
        change, force = np.split(np.array(function(x, u, numbers.vector))[:, 0], [7])
        rotation, rates = rotation_body_to_world(x[3:6]), body_rates_of(x[None, 3:6], x[None, 9:12])[0]
        ahead = [
            body_rates_of((x[3:6] + h * x[9:12])[None], (x[9:12] + h * change[3:6])[None])[0] for h in (1e-6, -1e-6)
        ]
        linear = rotation.T @ x[6:9]
        configuration = np.concatenate([pinocchio.SE3ToXYZQUAT(pinocchio.SE3(rotation, x[:3])), x[14:]])
        velocity = np.concatenate([linear, rates, np.zeros(4)])
        acceleration = np.concatenate(
            [rotation.T @ change[:3] - np.cross(rates, linear), (ahead[0] - ahead[1]) / 2e-6, np.zeros(4)]
        )
        needed = pinocchio.rnea(free, free.createData(), configuration, velocity, acceleration)[:3]
        given = u[0] * np.array([0.0, 0.0, 1.0]) + rotation.T @ (numbers["vehicle.wind"] - force)
        np.testing.assert_allclose(needed, given, atol=1e-6)


def test_the_leaf_turns_the_vehicle_about_its_centre_of_mass(folder: Path, rng: np.random.Generator) -> None:
    model = massive(folder, "push")
    task, numbers = symbols(model), whole_body_numbers(model)
    function = ca.Function("f", [task.state, task.inputs, task.parameters], [task.contact_yaw_torque, task.force])
    x = random_state(model, rng)
    torque, force = (np.array(each)[:, 0] for each in function(x, np.zeros(8), numbers.vector))
    rotation = rotation_body_to_world(x[3:6])
    away = rotation @ (model.vehicle.tip_position(x[14:]) - model.vehicle.center_of_mass(x[14:]))
    assert torque[0] == pytest.approx(-np.cross(away, force)[2], abs=1e-9)
    center = model.vehicle.center_of_mass(model.goal_arm)
    about_center = model.vehicle.inertia(model.goal_arm)[2, 2] - model.vehicle.mass * center[:2] @ center[:2]
    assert numbers.one("vehicle.yaw_inertia") == yaw_inertia(model) == pytest.approx(about_center)


@pytest.mark.parametrize("task", ["paper", "push"])
def test_plans_bound_the_static_moment(folder: Path, task: str, rng: np.random.Generator) -> None:
    model = massive(folder, task)
    balance, pattern = balance_of(model.vehicle), ArmPattern.of(model.vehicle.arm)[0]
    assert balance is not None
    if task == "push":
        symbolic, numbers = symbols(model), whole_body_numbers(model)
        rows = constraints(symbolic)
    else:
        numbers = door_numbers(model)
        symbolic, rows, _ = quasi_static(pattern, model.vehicle.point_names, numbers, model.kinds)
    (row,) = [row for row in rows if row.name == "static moment"]
    arm = model.start_arm + rng.uniform(-0.5, 0.5, 4)
    x = np.concatenate([np.zeros(int(symbolic.state.numel()) - 4), arm])
    symbolic_row = ca.Function("h", [symbolic.state, symbolic.parameters], [row.expression])
    value = np.array(symbolic_row(x, numbers.vector))[:, 0]
    np.testing.assert_allclose(value, -balance.room(model.vehicle.center_of_mass(arm)), atol=1e-12)


def test_an_arm_without_mass_has_no_such_row(model: Model) -> None:
    pattern, _ = ArmPattern.of(model.vehicle.arm)
    _, rows, _ = quasi_static(pattern, model.vehicle.point_names, door_numbers(model), model.kinds)
    assert "static moment" not in {row.name for row in rows}


@pytest.mark.slow
def test_a_plan_keeps_the_centre_of_mass_where_the_rotors_hold_it(folder: Path) -> None:
    """A bound halfway to where a plan without it takes the centre of mass."""
    model = massive(folder, "paper")
    balance, planner = balance_of(model.vehicle), Planner(model)
    assert balance is not None

    def outward(plan: Plan) -> np.ndarray:
        centers = [model.vehicle.center_of_mass(state[5:]) for state in plan.states]
        return np.array([balance.normals @ center[:2] for center in centers])

    free = planner.plan(model.start_state)
    along = outward(free)
    assert free.status is PlanStatus.CONVERGED and (along <= balance.reaches).all()
    bound = np.where(along[-1] > along[0] + 1e-4, 0.5 * (along[0] + along[-1]), balance.reaches)
    assert (bound < balance.reaches).any(), "the plan carries the arm outward"
    planner.update_numbers({"balance.reaches": bound})
    bounded = planner.plan(model.start_state)
    assert bounded.status is PlanStatus.CONVERGED and bounded.cost > free.cost
    assert (outward(bounded)[1:] <= bound + 1e-6).all()
    assert outward(bounded).max() == pytest.approx(bound[along.max(axis=0) > bound].max(), abs=1e-4)
