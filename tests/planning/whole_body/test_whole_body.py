"""The whole-body problem: forces against their potential, loops against their lag, rows against the model's own."""

from __future__ import annotations

import math
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from task_in_numbers import TaskInNumbers
from urdf_variants import DOOR, write_edited, write_mirrored, write_moved

from doorman.kinematics.numbers import Numbers
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.ocp.solvers.hybrid import Hybrid
from doorman.ocp.solvers.options import SolverOptions
from doorman.ocp.solvers.solution import PlanStatus
from doorman.planning.whole_body.contact import depth_of, stick_place, whole_body_state
from doorman.planning.whole_body.numbers import whole_body_numbers
from doorman.planning.whole_body.problem import whole_body_problem
from doorman.scenario import Scenario

Array = np.ndarray


@pytest.fixture(scope="module")
def numeric() -> TaskInNumbers:
    return TaskInNumbers(Model("push"))


def quiet(numbers: Numbers) -> Numbers:
    """No friction in the hinge, and none at the tip."""
    return numbers.replaced({"contact.friction": 0.0, "contact.slip_damping": 0.0, "door.friction": 0.0})


def test_a_hover_in_free_air_is_at_rest(numeric: TaskInNumbers) -> None:
    x = numeric.at_the_leaf(-0.5)
    after = numeric.function(numeric.task.next_state)(x, numeric.hover, quiet(numeric.numbers))
    np.testing.assert_allclose(after, x, atol=5e-5)  # the spring's tail, 3 mN half a metre away


def test_contact_force_is_the_slope_of_the_springs_energy(numeric: TaskInNumbers) -> None:
    """On vehicle, on its heading and on the leaf: one potential, three equations of motion."""
    numbers, task = quiet(numeric.numbers), numeric.task
    depth, change = numeric.function(task.depth), numeric.function(task.rates_of_change)
    stiffness, width = numbers.one("contact.stiffness"), 2.0 * numbers.one("contact.smoothing")

    def energy(x: Array) -> float:
        d = float(depth(x, numeric.hover, numbers))
        root = math.hypot(d, width)
        return 0.25 * stiffness * (d * d + d * root + width * width * math.asinh(d / width))

    x = numeric.at_the_leaf(0.0015, attitude=np.array([0.05, 0.1, -0.4]))
    free = numeric.at_the_leaf(-1e3, attitude=x[3:6])
    felt = change(x, numeric.hover, numbers) - change(free, numeric.hover, numbers)
    mass, inertia = numbers.one("vehicle.mass"), numbers.one("door.inertia")
    for index, force in ((0, mass * felt[0]), (1, mass * felt[1]), (2, mass * felt[2]),
                         (5, numbers.one("vehicle.yaw_inertia") * felt[5]), (12, inertia * felt[6])):  # fmt: skip
        step = np.zeros(len(x))
        step[index] = 1e-6
        slope = (energy(x + step) - energy(x - step)) / 2e-6
        assert force == pytest.approx(-slope, abs=2e-3), index
    assert mass * np.linalg.norm(felt[:3]) > 2.0


def test_friction_stays_in_its_cone_and_holds_back(numeric: TaskInNumbers) -> None:
    task, numbers = numeric.task, numeric.numbers.replaced({"contact.friction": 0.5, "contact.slip_damping": 0.0})
    force, pressed = numeric.function(task.force), numeric.function(task.normal_force)
    held = numeric.function(ca.vertcat(ca.dot(task.leaf_direction, task.force), ca.dot(task.leaf.up, task.force)))
    x = numeric.at_the_leaf(0.001)
    for stick in ([0.001, 0.0], [0.0, -0.01], [0.3, 0.4]):
        given = numbers.replaced({"contact.stick": stick})
        along, up = held(x, numeric.hover, given)
        limit = 0.5 * float(pressed(x, numeric.hover, given))
        assert math.hypot(along, up) < limit
        assert along * stick[0] <= 0.0 and up * stick[1] <= 0.0  # a tip that was displaced is drawn back
    assert math.hypot(along, up) > 0.99 * limit
    assert np.linalg.norm(force(x, numeric.hover, numbers)) == pytest.approx(float(pressed(x, numeric.hover, numbers)))


def test_damping_only_acts_in_contact(numeric: TaskInNumbers) -> None:
    pressed = numeric.function(numeric.task.normal_force)
    still, moving = numeric.at_the_leaf(0.002), numeric.at_the_leaf(0.002)
    moving[6:9] = 0.1 * np.array([math.sin(1.2), -math.cos(1.2), 0.0])
    more = pressed(moving, numeric.hover, numeric.numbers) - pressed(still, numeric.hover, numeric.numbers)
    assert 0.5 * 0.1 * numeric.numbers.one("contact.damping") < more < 0.1 * numeric.numbers.one("contact.damping")
    moving[:3] -= 0.5 * moving[6:9] / 0.1
    assert abs(float(pressed(moving, numeric.hover, numeric.numbers))) < 0.05


def test_roll_reaches_its_command_with_the_loops_lag(numeric: TaskInNumbers) -> None:
    step, numbers = numeric.function(numeric.task.next_state), numeric.numbers
    x, u = numeric.at_the_leaf(-0.5), numeric.hover
    u[1] = 0.1
    missing, path = 0.0, []
    for _ in range(100):
        missing += numbers.one("plan.time_step") * (0.1 - x[3])
        x = step(x, u, numbers)
        path.append(x[3])
    assert x[3] == pytest.approx(0.1, abs=5e-4)
    assert missing / 0.1 == pytest.approx(1.0 / numbers.one("vehicle.attitude_gain"), rel=0.03)
    assert path[0] < 0.7 * 0.1 * (
        1.0 - math.exp(-numbers.one("plan.time_step") * numbers.one("vehicle.attitude_gain"))
    )  # the rate has a lag of its own


def test_a_push_beside_the_centre_turns_the_vehicle_against_a_bounded_torque(numeric: TaskInNumbers) -> None:
    numbers = quiet(numeric.numbers)
    change = numeric.function(numeric.task.rates_of_change)
    x, u = numeric.at_the_leaf(0.004, attitude=np.array([0.0, 0.0, 0.2])), numeric.hover
    bound = float(np.asarray(whole_body_problem(numeric.model).bounds.input_upper)[3])
    turns = change(x, u, numbers)[5]
    u[3] = -math.copysign(bound, turns)
    assert change(x, u, numbers)[5] * turns > 0.0


def test_a_slow_leaf_rests_before_the_goal(numeric: TaskInNumbers) -> None:
    """The claim of the module: with no more force than (1 − η) of the resistance allows, the leaf stays in S."""
    share, friction, step = 0.2, 0.8, 2e-3
    inertia, goal = numeric.numbers.one("door.inertia"), numeric.numbers.one("reference.joint")
    numbers = quiet(numeric.numbers).replaced(
        {"door.friction": friction, "door.friction_rate": 1e-4, "door.damping": 0.0}
    )
    task = numeric.task
    change = numeric.function(ca.vertcat(task.rates_of_change[6]))
    lever = numeric.model.coupling.distance_from_hinge
    deepest = depth_of((1.0 - share) * friction / lever, numbers)
    angle = goal + 0.15
    rate = -math.sqrt(2.0 * share * friction / inertia * 0.15)
    while rate < -1e-3:
        x = numeric.at_the_leaf(deepest, angle)
        velocity = lever * rate * np.array([-math.sin(angle), math.cos(angle), 0.0])
        x[6:9], x[13] = velocity, rate
        assert 0.5 * rate**2 - share * friction / inertia * (angle - goal) < 1e-4
        rate += step * float(change(x, numeric.hover, numbers))
        angle += step * rate
    assert angle >= goal - 1e-3


@pytest.mark.parametrize("force", [0.1, 1.0, 8.0])
def test_a_plan_begins_with_the_force_that_is_felt(numeric: TaskInNumbers, force: float) -> None:
    numbers, task = numeric.numbers, numeric.task
    x = numeric.at_the_leaf(depth_of(force, numbers))
    assert float(numeric.function(task.spring_force)(x, numeric.hover, numbers)) == pytest.approx(force, rel=1e-9)
    dragged = np.array([0.3, -0.2]) * force
    stick = stick_place(np.zeros(2), dragged, force, numbers)
    along = ca.vertcat(ca.dot(task.leaf_direction, task.force), ca.dot(task.leaf.up, task.force))
    found = numeric.function(along)(x, numeric.hover, numbers.replaced({"contact.stick": stick}))
    np.testing.assert_allclose(found, dragged, rtol=1e-6)


def image(right: Model, left: Model, x: Array) -> Array:
    """A state at a door on the right, as it is at the mirrored door wherever that stands."""
    n = right.n_arm
    mirror = np.array([-1.0, 1.0, -1.0])
    seen = [right.door.in_doorway(part) for part in (x[:3] - right.door.hinge_position, x[6:9])]
    position, velocity = (left.door.from_doorway(part) for part in seen)
    yaw = np.array([0.0, 0.0, left.door.azimuth + right.door.azimuth])
    arm = np.array([-1.0, *np.ones(n - 1)])  # the shipped arm's first joint turns, the others bend
    return np.concatenate(
        [position + left.door.hinge_position, mirror * x[3:6] + yaw, velocity, mirror * x[9:12], x[12:14], arm * x[14:]]
    )


def test_the_plan_of_a_left_door_turned_and_moved_is_the_mirror_image(numeric: TaskInNumbers, tmp_path: Path) -> None:
    door = write_moved(tmp_path / "moved.urdf", write_mirrored(tmp_path / "left.urdf", DOOR), (4.0, -1.0, 0.3), 2.2)
    left = Model(Scenario.load("push", {"door.urdf": str(door)}))
    x, plans = numeric.at_the_leaf(-0.03, 1.4), []
    for model in (numeric.model, left):
        numbers = whole_body_numbers(model).replaced({"door.friction": 0.5})
        solver = Hybrid(
            whole_body_problem(model, numbers),
            SolverOptions(largest_multiplier=100.0, hessian="gauss-newton", feasibility=2e-3),
        )
        assert solver.run(image(numeric.model, model, x) if model is left else x)[0] is PlanStatus.CONVERGED
        plans.append(solver.trajectory()[0].copy())
    right = np.array([image(numeric.model, left, state) for state in plans[0]])
    np.testing.assert_allclose(plans[1], right, atol=1e-3)


@pytest.mark.parametrize("before", [-0.02, 0.04])
def test_a_face_beside_the_hinges_axis_is_where_the_door_has_it(
    numeric: TaskInNumbers, tmp_path: Path, before: float
) -> None:
    """Depth, lever and place of the tip are those of `Door`, whichever way the door stands."""
    leaf = '<collision name="leaf">\n      <origin xyz="0.6 -0.02 0.8"'
    proud = write_edited(tmp_path / "proud.urdf", DOOR, (leaf, leaf.replace("-0.02", f"{before - 0.02:g}")))
    model = Model(Scenario.load("push", {"door.urdf": str(proud)}))
    assert model.door.surface_offset == pytest.approx(before, abs=1e-9)
    numbers, depth = whole_body_numbers(model), numeric.function(numeric.task.depth)
    lever = numeric.function(numeric.task.lever)
    for angle in (math.pi / 2, 1.0, 0.4):
        posture = model.on_the_way(angle)
        place = model.coupling.vehicle_position(posture[:3], angle, posture[5:]) + 0.002 * model.door.normal(angle)
        x = whole_body_state(place, posture[:3], np.zeros(3), np.zeros(3), angle, 0.0, posture[5:])
        assert depth(x, numeric.hover, numbers) == pytest.approx(0.002, abs=1e-9)
        found = lever(x, numeric.hover, numbers)
        np.testing.assert_allclose(found, model.door.lever(angle, model.coupling.distance_from_hinge), atol=1e-9)


@pytest.mark.parametrize("attitude", [[0.0, 0.0, -0.3], [0.1, -0.05, 0.4]])
def test_the_force_at_the_tip_turns_the_vehicle_beside_its_command(attitude: list[float]) -> None:
    """By its moment over the attitude loop's stiffness: what is commanded against it holds the vehicle still."""
    numeric = TaskInNumbers(Model("push"))
    task, numbers = numeric.task, numeric.numbers
    x = numeric.at_the_leaf(0.001, attitude=np.array(attitude))
    turned = numeric.function(task.turned_by_contact)(x, numeric.hover, numbers)
    rotation = rotation_body_to_world(np.array(attitude))
    force = numeric.function(task.force)(x, numeric.hover, numbers)
    moment = -np.cross(numeric.model.vehicle.tip_position(x[14:]), rotation.T @ force)
    stiffness = numeric.model.attitude_loop.stiffness * np.diag(numeric.model.vehicle_inertia)[:2]
    np.testing.assert_allclose(turned, moment[:2] / stiffness, rtol=1e-9)
    assert np.abs(turned).max() > 1e-3
    held = numeric.hover
    held[1:3] = np.array(attitude[:2]) - turned
    np.testing.assert_allclose(numeric.function(task.rates_of_change)(x, held, numbers)[3:5], 0.0, atol=1e-9)
