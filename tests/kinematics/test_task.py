"""The symbolic task against Pinocchio's numbers."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from attitude_matrices import euler_rate_matrix

from doorman.dynamics.quasi_static import QuasiStaticTask
from doorman.exceptions import DimensionError
from doorman.kinematics.coupling import Coupling
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.task_numbers import task_numbers
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern


def task_of(coupling: Coupling) -> tuple[QuasiStaticTask, Numbers]:
    numbers = task_numbers(coupling.vehicle, coupling.door, coupling.distance_from_hinge, coupling.height)
    pattern, _ = ArmPattern.of(coupling.vehicle.arm)
    return QuasiStaticTask(pattern, coupling.vehicle.point_names, numbers), numbers


def random_point(n: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    x = np.concatenate([rng.uniform(-1.0, 1.0, 3), rng.uniform(0.1, 1.5, 1), rng.normal(size=1), rng.normal(size=n)])
    return x, np.concatenate([rng.uniform(5.0, 40.0, 1), rng.normal(size=3 + n)])


def test_positions_are_pinocchios(coupling: Coupling, rng: np.random.Generator) -> None:
    task, numbers = task_of(coupling)
    expressions = [task.position, task.contact_point, *task.points_in_body.values(), *task.points.values()]
    values = ca.Function("values", [task.state, task.parameters], expressions)
    for _ in range(5):
        x, _ = random_point(coupling.vehicle.n_arm, rng)
        position, contact, *points = (np.array(each)[:, 0] for each in values(x, numbers.vector))
        expected = coupling.vehicle_position(x[:3], x[3], x[5:])
        np.testing.assert_allclose(position, expected, atol=1e-14)
        np.testing.assert_allclose(contact, coupling.door.contact_point(x[3], 0.65, 0.9), atol=1e-14)
        in_body, count = coupling.vehicle.point_positions(x[5:]), len(coupling.vehicle.point_names)
        np.testing.assert_allclose(points[:count], in_body, atol=1e-14)
        in_world = expected + in_body @ rotation_body_to_world(x[:3]).T
        np.testing.assert_allclose(points[count:], in_world, atol=1e-14)


def test_the_velocity_is_the_positions_rate(coupling: Coupling, rng: np.random.Generator) -> None:
    task, numbers = task_of(coupling)
    value = ca.Function("velocity", [task.state, task.inputs, task.parameters], [task.velocity])
    for _ in range(3):
        x, u = random_point(coupling.vehicle.n_arm, rng)
        rates = np.concatenate([euler_rate_matrix(x[:3]) @ u[1:4], x[4:5], [0.0], u[4:]])
        ahead, behind = (
            coupling.vehicle_position(moved[:3], moved[3], moved[5:]) for moved in (x + 1e-6 * rates, x - 1e-6 * rates)
        )
        np.testing.assert_allclose(np.array(value(x, u, numbers.vector))[:, 0], (ahead - behind) / 2e-6, atol=1e-8)


def test_numbers_go_by_their_names() -> None:
    numbers = Numbers({"a": 1.0, "b": [2.0, 3.0]})
    np.testing.assert_array_equal(numbers.vector, [1.0, 2.0, 3.0])
    other = numbers.replaced({"b": [4.0, 5.0]})
    np.testing.assert_array_equal(other["b"], [4.0, 5.0])
    np.testing.assert_array_equal(numbers["b"], [2.0, 3.0])
    assert other.and_also({"c": 6.0}).one("c") == 6.0
    with pytest.raises(DimensionError, match="no such number.*a, b"):
        numbers.replaced({"d": 1.0})
    with pytest.raises(DimensionError, match="wrong count"):
        numbers.replaced({"b": [1.0, 2.0, 3.0]})
    with pytest.raises(ValueError, match="read-only"):
        numbers.vector[0] = 2.0
