"""The Lagrangian model against Pinocchio and its limits, and its derivatives against differences."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from finite_differences import central_difference
from lagrangian_in_numbers import LagrangianModel
from pinocchio_reference import constrained_dynamics
from urdf_variants import DOOR, VEHICLE, write_arm_of, write_door, write_edited, write_massive

from doorman.kinematics.coupling import Coupling
from doorman.kinematics.doors.door import Door
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.model import Model
from doorman.scenario import DoorSection, Scenario

RESISTING = DoorSection(damping=0.4, friction=0.6, stiffness=1.5, rest_angle=1.2)


@pytest.fixture(scope="module", params=["paper", "massive", 1, 2, 7])
def lagrangian(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> LagrangianModel:
    """A door that resists, the paper's vehicle, one whose arm has mass, and others with unlike inertias."""
    kind = request.param
    if kind == "paper":
        return LagrangianModel(Coupling(Vehicle(VEHICLE), Door(DOOR, RESISTING), 0.7, 0.8), 0.02, disturbance=0.35)
    folder: Path = tmp_path_factory.mktemp("urdf")
    if kind == "massive":
        return LagrangianModel(Coupling(Vehicle(massive(folder)), Door(DOOR, RESISTING), 0.7, 0.8), 0.02)
    vehicle = write_edited(
        folder / "vehicle.urdf",
        write_arm_of(folder / "arm.urdf", kind, odd_axes_seed=kind),
        (
            'ixx="0.045" ixy="0" ixz="0" iyy="0.045" iyz="0"',
            'ixx="0.06" ixy="0.01" ixz="-0.007" iyy="0.05" iyz="0.004"',
        ),
        ('<mass value="3.0" />', '<mass value="2.2" />'),
    )
    door = Door(write_door(folder / "door.urdf", width=1.45, mass=18.0), RESISTING)
    return LagrangianModel(Coupling(Vehicle(vehicle), door, 0.9, 1.1), 0.01)


def massive(folder: Path) -> Path:
    """0.6 kg on the four links, beside their axes, and a body whose centre of mass is not its origin."""
    shares = {"servo_1": 0.11, "servo_2": 0.17, "servo_3": 0.14, "servo_4": 0.18}
    arm = write_massive(folder / "arm.urdf", shares, center=(0.04, 0.01, -0.02))
    return write_edited(
        folder / "massive.urdf",
        arm,
        ('<origin xyz="0 0 0" rpy="0 0 0" />', '<origin xyz="-0.03 0.01 0.02" rpy="0 0 0" />'),
    )


def random_state(model: LagrangianModel, rng: np.random.Generator) -> np.ndarray:
    return np.concatenate(
        [rng.uniform(-1.2, 1.2, 3), rng.uniform(-0.3, 1.7, 1), rng.normal(size=4), rng.uniform(-1.5, 1.5, model.n_arm)]
    )


def random_inputs(model: LagrangianModel, rng: np.random.Generator) -> np.ndarray:
    return np.concatenate([rng.uniform(5.0, 48.0, 1), rng.uniform(-2.0, 2.0, 3), rng.uniform(-3.0, 3.0, model.n_arm)])


def body_acceleration(state: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """Ω̇ of Ω = W⁻¹(Φ)Φ̇ by a complex step along the motion: exact to rounding."""
    roll, pitch, _ = state[:3] + 1e-30j * state[4:7]
    cr, sr, cp, sp = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch)
    matrix = np.array([[1.0, 0.0, -sp], [0.0, cr, sr * cp], [0.0, -sr, cr * cp]])
    return np.imag(matrix @ (state[4:7] + 1e-30j * acceleration)) / 1e-30


def test_accelerations_agree_with_pinocchio(lagrangian: LagrangianModel, rng: np.random.Generator) -> None:
    for _ in range(25):
        x, u = random_state(lagrangian, rng), random_inputs(lagrangian, rng)
        reference = constrained_dynamics(lagrangian, x, u)
        rate = lagrangian.derivative(x, u)
        assert rate[7] == pytest.approx(reference.door_acceleration, rel=1e-9, abs=1e-9)
        np.testing.assert_allclose(body_acceleration(x, rate[4:7]), reference.body_acceleration, rtol=1e-9, atol=1e-9)
        np.testing.assert_array_equal(rate[:4], x[4:8])
        np.testing.assert_array_equal(rate[8:], u[4:])


def test_contact_force_agrees_with_pinocchio(lagrangian: LagrangianModel, rng: np.random.Generator) -> None:
    for _ in range(10):
        x, u = random_state(lagrangian, rng), random_inputs(lagrangian, rng)
        reference = constrained_dynamics(lagrangian, x, u)
        np.testing.assert_allclose(lagrangian.contact_force(x, u), reference.force_on_door, rtol=1e-9, atol=1e-8)


def test_sensitivities_of_a_step(lagrangian: LagrangianModel, rng: np.random.Generator) -> None:
    nx = lagrangian.nx
    for _ in range(5):
        z = np.concatenate([random_state(lagrangian, rng), random_inputs(lagrangian, rng)])
        by_state, by_input = lagrangian.step_jacobian(z[:nx], z[nx:])
        assert (by_state.shape, by_input.shape) == ((nx, nx), (nx, lagrangian.nu))
        numeric = central_difference(lambda z: lagrangian.step(z[:nx], z[nx:]), z)
        error = np.hstack([by_state, by_input]) - numeric
        assert np.abs(error).max() < 1e-7 * max(1.0, np.abs(numeric).max())


def test_hover_with_the_door_at_rest_is_an_equilibrium() -> None:
    """Thrust m g against gravity; the torque holds nothing, for the tip carries no force."""
    model = LagrangianModel(Coupling(Vehicle(VEHICLE), Door(DOOR), 0.7, 0.8), 0.02)
    x = np.array([0, 0, -0.4, 1.2, 0, 0, 0, 0, 0, 1.0, -0.6, -0.4])
    u = np.array([3.0 * 9.81, 0, 0, 0, 0, 0, 0, 0])
    np.testing.assert_allclose(model.derivative(x, u), np.zeros(12), atol=1e-13)
    np.testing.assert_allclose(model.contact_force(x, u), np.zeros(3), atol=1e-13)
    np.testing.assert_allclose(model.step(x, u), x, atol=1e-14)


def test_a_vehicle_without_mass_leaves_the_quasi_static_door(tmp_path: Path, rng: np.random.Generator) -> None:
    """With m_A → 0 the tip passes on the thrust and nothing else: α̈ tends to the simplified model's, linearly in m_A."""
    x = np.concatenate([rng.uniform(-0.5, 0.5, 3), [1.1], rng.normal(size=4), [0.2, 0.9, -0.7, 0.3]])
    u = np.concatenate([[30.0, 0.3, -0.2, 0.1], np.zeros(4)])
    scenario = Scenario(door=RESISTING)
    expected = Model(scenario).derivative([*x[:4], *x[7:]], [u[0], 0.0, 0.0, 0.0, *u[4:]])[4]
    errors = []
    for mass in (1e-4, 1e-5, 1e-6):
        path = write_edited(tmp_path / "v.urdf", VEHICLE, ('<mass value="3.0"/>', f'<mass value="{mass}"/>'))
        coupling = Coupling(Vehicle(path), Door(DOOR, RESISTING), 0.7, 0.8)
        errors.append(abs(LagrangianModel(coupling, 0.02).derivative(x, u)[7] - expected))
    assert errors[2] < 1e-4
    np.testing.assert_allclose([errors[0] / errors[1], errors[1] / errors[2]], 10.0, rtol=0.02)
