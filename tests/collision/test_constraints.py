"""The analytic constraints against their geometry, and their Jacobian against finite differences, for arms of any length."""

from __future__ import annotations

import math
import re
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from finite_differences import central_difference
from paper_door import door_normal
from urdf_variants import robot_data_vehicle, write_arm_of, write_door

from doorman.collision.constraints import collision_constraints
from doorman.dynamics.quasi_static import QuasiStaticTask
from doorman.exceptions import DimensionError
from doorman.kinematics.doors.door import Door
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.task_numbers import task_numbers
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.model import Model
from doorman.resources import urdf_directory
from doorman.scenario import ContactSection, DoorSection, Scenario, VehicleSection

MARGIN = 0.02
FURTHER = [pytest.param(name, marks=pytest.mark.slow) for name in ("hextilt_flying_arm_5", 3, 5, 7)]
"""Their kernels take long to compile."""


@pytest.fixture(scope="module", params=["paper", "borinot_flying_arm_2", 2, *FURTHER])
def any_model(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Model:
    """Models of arms with 2 to 7 joints, on another door than the paper's but for the first."""
    kind = request.param
    if kind == "paper":
        return Model(Scenario.load("paper"))
    folder: Path = tmp_path_factory.mktemp("urdf")
    door = DoorSection(urdf=str(write_door(folder / "door.urdf", width=1.4, mass=15.0)), frame_height=9.0)
    if isinstance(kind, int):
        vehicle = VehicleSection(urdf=str(write_arm_of(folder / "vehicle.urdf", kind, odd_axes_seed=kind)))
    else:
        _, vehicle = robot_data_vehicle(kind)
    return Model(Scenario(vehicle=vehicle, door=door, contact=ContactSection(distance_from_hinge=0.6)))


def random_states(model: Model, count: int, rng: np.random.Generator) -> np.ndarray:
    states = rng.uniform(-1.3, 1.3, (count, model.nx))
    states[:, 3] = rng.uniform(0.0, 1.7, count)
    states[:, 2] = states[:, 3] - math.pi / 2 + rng.uniform(-0.8, 0.8, count)
    return states


def test_there_are_n_plus_2_rows(any_model: Model) -> None:
    n = any_model.n_arm
    assert any_model.n_constraints == len(any_model.constraint_names) == n + 2
    assert any_model.constraints(any_model.start_state).shape == (n + 2,)
    assert any_model.constraint_jacobian(any_model.start_state).shape == (n + 2, 5 + n)


def test_rows_of_the_arm_are_heights_in_the_body(any_model: Model, rng: np.random.Generator) -> None:
    for x in random_states(any_model, 10, rng):
        heights = any_model.vehicle.point_positions(x[5:])[:, 2]
        np.testing.assert_allclose(any_model.constraints(x)[:-3], heights, atol=1e-14)


def test_row_of_the_leaf_is_the_farthest_point_of_the_rim_beyond_its_plane(
    any_model: Model, rng: np.random.Generator
) -> None:
    """Walk around the rim of the disc in the world; n_D points away from the vehicle, through the leaf."""
    bearings = np.linspace(0.0, 2.0 * math.pi, 3601)
    rim_in_body = any_model.vehicle.radius * np.array([np.cos(bearings), np.sin(bearings), np.zeros(len(bearings))])
    for x in random_states(any_model, 10, rng):
        position = any_model.coupling.vehicle_position(x[:3], x[3], x[5:])
        rim = position[:, None] + rotation_body_to_world(x[:3]) @ rim_in_body
        beyond = door_normal(x[3]) @ (rim - any_model.door.hinge_position[:, None])
        assert any_model.constraints(x)[-3] == pytest.approx(beyond.max(), abs=5e-7)


def test_rows_of_the_jambs_are_the_vehicles_place_in_the_doorway(any_model: Model, rng: np.random.Generator) -> None:
    radius, width = any_model.vehicle.radius, any_model.door.width
    for x in random_states(any_model, 10, rng):
        across = (any_model.coupling.vehicle_position(x[:3], x[3], x[5:]) - any_model.door.hinge_position)[1]
        latch, hinge = any_model.constraints(x)[-2:]
        assert latch == pytest.approx(across - (width - radius), abs=1e-13)
        assert hinge == pytest.approx(radius - across, abs=1e-13)


def test_jacobian_against_finite_differences(any_model: Model, rng: np.random.Generator) -> None:
    for x in random_states(any_model, 10, rng):
        numeric = central_difference(any_model.constraints, x)
        np.testing.assert_allclose(any_model.constraint_jacobian(x), numeric, atol=2e-8)


def test_many_states_at_once(any_model: Model, rng: np.random.Generator) -> None:
    states = random_states(any_model, 7, rng)
    one_by_one = np.array([any_model.constraints(x) for x in states])
    np.testing.assert_allclose(any_model.constraints_along(states), one_by_one, rtol=1e-12, atol=1e-15)
    states.flags.writeable = False
    np.testing.assert_allclose(any_model.constraints_along(states), one_by_one, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(any_model.constraints_along(np.asfortranarray(states)), one_by_one)


def test_start_of_the_paper_by_hand(model: Model) -> None:
    """Closed door, level: the leaf's row is R_A − d_x, the jambs' rows are 0.7 m from the hinge of a doorway of 1.2 m."""
    h = model.constraints(model.start_state)
    tip_ahead = model.vehicle.tip_position(model.start_arm)[0]
    np.testing.assert_allclose(h[3:], [0.40 - tip_ahead, 0.7 - 0.8, 0.4 - 0.7], atol=1e-14)


def test_a_disc_parallel_to_the_leaf_is_a_kink_with_a_finite_slope(model: Model) -> None:
    """Rolled by 90° before the open door, the disc lies along the leaf: the root in row 2 has no derivative there."""
    x = np.concatenate([[math.pi / 2, 0.0, 0.0, 0.0, 0.0], model.goal_arm])
    h, jacobian = model.constraints(x), model.constraint_jacobian(x)
    assert np.isfinite(h).all()
    assert np.isfinite(jacobian).all()
    tip = model.vehicle.tip_position(model.goal_arm)
    assert h[-3] == pytest.approx(-(rotation_body_to_world(x[:3]).T @ door_normal(0.0)) @ tip, abs=1e-6)
    assert np.abs(jacobian).max() < 2.0


@pytest.mark.parametrize("state", [np.zeros(8), np.full(9, np.nan), np.zeros((1, 9)), "state"])
def test_what_is_not_a_state_is_an_error(model: Model, state: object) -> None:
    for function in (model.constraints, model.constraint_jacobian):
        with pytest.raises(DimensionError, match="state"):
            function(state)


@pytest.mark.parametrize("states", [np.zeros(9), np.zeros((3, 8)), np.zeros((2, 3, 9))])
def test_what_are_not_states_is_an_error(model: Model, states: np.ndarray) -> None:
    with pytest.raises(DimensionError, match="states"):
        model.constraints_along(states)


@pytest.fixture(params=[(joints, height) for joints in (0, 1, 4) for height in (0.2, -0.05)])
def lifted(request: pytest.FixtureRequest, tmp_path: Path) -> Vehicle:
    joints, height = request.param
    text = write_arm_of(tmp_path / "arm.urdf", joints).read_text(encoding="utf-8")
    first = "eta_1" if joints else "tip_mount"
    text, count = re.subn(
        rf'(<joint name="{first}".*?xyz="\S+ \S+ )[^"]*"', rf'\g<1>{height}"', text, count=1, flags=re.DOTALL
    )
    assert count == 1
    path = tmp_path / "lifted.urdf"
    path.write_text(text, encoding="utf-8")
    return Vehicle(path)


def test_an_arm_stays_on_its_side_of_the_rotors(lifted: Vehicle, rng: np.random.Generator) -> None:
    vehicle = lifted
    root = (vehicle.arm.links if vehicle.n_arm else vehicle.arm.point_offsets)[0]
    above = root[2] > 0.0
    assert vehicle.arm.above == above
    pattern, _ = ArmPattern.of(vehicle.arm)
    numbers = task_numbers(vehicle, Door(urdf_directory() / "hinged_door.urdf"), 0.7, 0.8)
    task = QuasiStaticTask(pattern, vehicle.point_names, numbers)
    rows = collision_constraints(task, MARGIN, ("arm",))
    assert [row.name for row in rows] == [
        f"{name} {'above' if above else 'below'} body" for name in vehicle.point_names
    ]
    h = ca.Function("h", [task.state, task.parameters], [ca.vertcat(*(row.expression for row in rows))])
    for posture in rng.uniform(-1.5, 1.5, (5, vehicle.n_arm)):
        heights = vehicle.point_positions(posture)[:, 2]
        expected = MARGIN + (-heights if above else heights)
        if not vehicle.n_arm:
            expected = np.array([-1.0])  # a stick is never in its own body's way
        found = np.array(h(np.concatenate([np.zeros(5), posture]), numbers.vector)).ravel()
        np.testing.assert_allclose(found, expected, atol=1e-14)
