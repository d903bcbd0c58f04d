"""Masses of vehicle and arm: the symbols against Pinocchio, and the Jacobian of the centre of mass against differences."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest
from finite_differences import central_difference
from urdf_variants import VEHICLE, robot_data_vehicle, write_arm_of, write_edited, write_massive

from doorman.kinematics.symbols import SymbolicBodies
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.kinematics.vehicles.vehicle import Vehicle


@pytest.fixture(params=["shipped", "odd", "slides", "borinot_flying_arm_2", "hextilt_flying_arm_5"])
def massive(request: pytest.FixtureRequest, tmp_path: Path) -> Vehicle:
    """Vehicles whose arms have mass."""
    kind, path = request.param, tmp_path / "arm.urdf"
    if kind == "shipped":
        return Vehicle(write_massive(path, {"servo_2": 0.2, "servo_4": 0.3}))
    if kind in ("odd", "slides"):
        plain = write_arm_of(
            tmp_path / "plain.urdf", 5, odd_axes_seed=3, kinds={2: "prismatic"} if kind == "slides" else {}
        )
        return Vehicle(write_massive(path, {"servo_1": 0.3, "servo_3": 0.2, "servo_5": 0.4, "tip": 0.1}, source=plain))
    return Vehicle(*robot_data_vehicle(kind))


def test_symbols_agree_with_pinocchio(massive: Vehicle, rng: np.random.Generator) -> None:
    pattern, numbers = ArmPattern.of(massive.arm)
    named = {name.partition(".")[2]: ca.DM(value) for name, value in massive.bodies.numbers().items()}
    for _ in range(5):
        angles = rng.uniform(-1.5, 1.5, massive.n_arm)
        bodies = SymbolicBodies(pattern, ca.DM(numbers), ca.DM(angles), SimpleNamespace(**named))
        center, inertia = (np.array(ca.evalf(ca.SX(each))) for each in (bodies.center, bodies.inertia()))
        expected = massive.center_of_mass(angles)
        np.testing.assert_allclose(center[:, 0], expected, atol=1e-13)
        about_origin = inertia + massive.mass * (expected @ expected * np.eye(3) - np.outer(expected, expected))
        np.testing.assert_allclose(about_origin, massive.inertia(angles), atol=1e-12)


def test_the_jacobian_of_the_centre_of_mass(massive: Vehicle, rng: np.random.Generator) -> None:
    for _ in range(3):
        angles = rng.uniform(-1.5, 1.5, massive.n_arm)
        expected = central_difference(massive.center_of_mass, angles)
        np.testing.assert_allclose(massive.center_of_mass_jacobian(angles), expected, atol=1e-7)


def test_a_stick_has_no_joints_to_move_its_mass(tmp_path: Path) -> None:
    stick = Vehicle(write_massive(tmp_path / "m.urdf", {"tip": 0.3}, source=write_arm_of(tmp_path / "s.urdf", 0)))
    assert stick.center_of_mass_jacobian(()).shape == (3, 0)
    assert not stick.bodies.balanced and stick.center_of_mass(())[0] > 0.03


def test_what_counts_as_an_arm_without_mass(tmp_path: Path) -> None:
    assert Vehicle(VEHICLE).bodies.balanced
    assert not Vehicle(write_massive(tmp_path / "arm.urdf", {"servo_4": 0.01})).bodies.balanced
    for offset, balanced in (("0.00005", True), ("0.0005", False)):
        beside = (
            '<origin xyz="0 0 0" rpy="0 0 0"/>\n      <mass',
            f'<origin xyz="{offset} 0 0" rpy="0 0 0"/>\n      <mass',
        )
        assert Vehicle(write_edited(tmp_path / "v.urdf", VEHICLE, beside)).bodies.balanced is balanced


def test_the_shipped_arm_with_mass_is_the_shipped_arm() -> None:
    plain, massive = Vehicle(VEHICLE), Vehicle(VEHICLE.with_name("hexarotor_arm_with_mass.urdf"))
    assert massive.mass == pytest.approx(plain.mass, abs=1e-6) and massive.bodies.masses[1:].sum() == pytest.approx(
        0.356
    )
    for name in ("axes", "links", "point_offsets"):
        np.testing.assert_array_equal(getattr(massive.arm, name), getattr(plain.arm, name))
    np.testing.assert_array_equal(massive.torque_limits, plain.torque_limits)
    assert (massive.radius, massive.max_thrust) == (plain.radius, plain.max_thrust)
    for inertia in massive.bodies.inertias:
        smallest, middle, largest = np.linalg.eigvalsh(inertia)
        assert smallest > 0.0 and smallest + middle >= largest * (1.0 - 1e-3)
