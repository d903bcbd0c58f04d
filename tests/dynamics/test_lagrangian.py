"""The Lagrangian model against Pinocchio's constrained dynamics of the free-flying vehicle tied to the door at the tip."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio
import pytest
from lagrangian_in_numbers import LagrangianModel, rotation_jacobian, translation_jacobian
from numpy.typing import NDArray
from urdf_variants import DOOR, VEHICLE, write_arm_of, write_door, write_edited, write_massive

from doorman.kinematics.coupling import Coupling
from doorman.kinematics.doors.door import Door
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.model import Model
from doorman.scenario import DoorSection, Scenario

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Reference:
    """What Pinocchio says at one state."""

    body_acceleration: Array
    """Ω̇, shape (3,)."""
    door_acceleration: float
    force_on_door: Array
    """At the tip, shape (3,), world frame."""


def constrained_dynamics(model: LagrangianModel, state: Array, inputs: Array) -> Reference:
    """Accelerations and contact force of vehicle and door from their URDFs, the arm's joints locked at H."""
    coupling = model.coupling
    flying = _locked_vehicle(model, state[8:])
    tied, root = flying.copy(), 1
    hinge = tied.addJoint(0, pinocchio.JointModelRZ(), coupling.door.model.jointPlacements[1], "hinge")
    tied.appendBodyToJoint(hinge, coupling.door.model.inertias[1], pinocchio.SE3.Identity())
    tip_frame = flying.getFrameId(coupling.vehicle.names.tip, pinocchio.FrameType.BODY)
    tip = pinocchio.SE3(np.eye(3), flying.frames[tip_frame].placement.translation)
    leaf = pinocchio.SE3(np.eye(3), np.array([coupling.distance_from_hinge, 0.0, coupling.height]))
    tie = pinocchio.RigidConstraintModel(
        pinocchio.ContactType.CONTACT_3D, tied, root, tip, hinge, leaf, pinocchio.ReferenceFrame.LOCAL
    )
    ties, tie_data, data = [tie], [tie.createData()], tied.createData()
    pinocchio.initConstraintDynamics(tied, data, ties, tie_data)
    position, velocity, force = _configuration(model, state, inputs)
    acceleration = pinocchio.constraintDynamics(tied, data, position, velocity, force, ties, tie_data)
    rotation = rotation_body_to_world(state[:3])
    return Reference(acceleration[3:6].copy(), float(acceleration[6]), -rotation @ data.lambda_c)


def _locked_vehicle(model: LagrangianModel, arm_angles: Array) -> pinocchio.Model:
    vehicle = model.coupling.vehicle
    free = pinocchio.buildModelFromUrdf(str(vehicle.urdf), pinocchio.JointModelFreeFlyer())
    position = pinocchio.neutral(free)
    position[7:] = arm_angles
    locked = [free.getJointId(name) for name in vehicle.joint_names]
    return pinocchio.buildReducedModel(free, locked, position)


def _configuration(model: LagrangianModel, state: Array, inputs: Array) -> tuple[Array, Array, Array]:
    """Position, velocity (both on the constraint) and generalised force: thrust and torque on the body, torque in the hinge."""
    coupling, q, q_rate = model.coupling, state[:4], state[4:8]
    rotation = rotation_body_to_world(q[:3])
    place = pinocchio.SE3(rotation, coupling.vehicle_position(q[:3], q[3], state[8:]))
    linear = rotation.T @ translation_jacobian(coupling, q[:3], q[3], state[8:]) @ q_rate
    angular = rotation_jacobian(q[:3]) @ q_rate
    hinge = -coupling.door.hinge_torque(q[3], q_rate[3]) - model.disturbance
    force = np.concatenate([[0.0, 0.0], inputs[:4], [hinge]])
    return (
        np.concatenate([pinocchio.SE3ToXYZQUAT(place), q[3:]]),
        np.concatenate([linear, angular, q_rate[3:]]),
        force,
    )


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
