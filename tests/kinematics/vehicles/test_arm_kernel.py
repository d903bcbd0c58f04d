"""The compiled arm against Pinocchio, for arms of any number of joints."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from urdf_variants import VEHICLE, robot_data_vehicle, write_arm_of

from doorman.kinematics.vehicles.arms.arm import ArmParameters, arm_kinematics, point_derivative
from doorman.kinematics.vehicles.vehicle import Vehicle


def check_against_pinocchio(vehicle: Vehicle) -> None:
    arm, n = ArmParameters.of(vehicle.arm), vehicle.n_arm
    for angles in np.random.default_rng(n).uniform(-2.5, 2.5, (10, n)):
        arm_kinematics(arm, angles)
        np.testing.assert_allclose(arm.points, vehicle.point_positions(angles), atol=2e-15)
        jacobians = vehicle.point_jacobians(angles)
        for point in range(len(arm.points)):
            kernel = np.array([point_derivative(arm, point, joint) for joint in range(n)]).T
            np.testing.assert_allclose(kernel, jacobians[point], atol=2e-15)


def test_shipped_arm() -> None:
    check_against_pinocchio(Vehicle(VEHICLE))


@pytest.mark.parametrize("name", ["borinot_flying_arm_2", "hextilt_flying_arm_5"])
def test_flying_arms_of_example_robot_data(name: str) -> None:
    check_against_pinocchio(Vehicle(*robot_data_vehicle(name)))


@pytest.mark.parametrize("joints", range(1, 8))
def test_arms_with_odd_axes(joints: int, tmp_path: Path) -> None:
    check_against_pinocchio(Vehicle(write_arm_of(tmp_path / "odd.urdf", joints, odd_axes_seed=10 + joints)))


def test_axes_need_not_be_of_unit_length(tmp_path: Path) -> None:
    text = VEHICLE.read_text(encoding="utf-8").replace('<axis xyz="0 -1 0"/>', '<axis xyz="0 -2 1"/>')
    (tmp_path / "v.urdf").write_text(text, encoding="utf-8")
    vehicle = Vehicle(tmp_path / "v.urdf")
    np.testing.assert_allclose(np.linalg.norm(vehicle.arm.axes, axis=1), 1.0, atol=1e-15)
    check_against_pinocchio(vehicle)


def test_compiled_arm_equals_its_plain_twin(rng: np.random.Generator) -> None:
    compiled, plain = (ArmParameters.of(Vehicle(VEHICLE).arm) for _ in range(2))
    angles = rng.uniform(-1.5, 1.5, 4)
    arm_kinematics(compiled, angles)
    arm_kinematics.py_func(plain, angles)
    np.testing.assert_allclose(compiled.points, plain.points, atol=1e-15)
    np.testing.assert_allclose(compiled.joints, plain.joints, atol=1e-15)


def test_parameters_have_their_own_memory() -> None:
    geometry = Vehicle(VEHICLE).arm
    one, other = ArmParameters.of(geometry), ArmParameters.of(geometry)
    assert not any(np.shares_memory(a, b) for a, b in zip(one, other, strict=True))
    assert not geometry.links.flags.writeable
