"""Derivatives and integration of the Lagrangian model: finite differences, order of convergence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from finite_differences import central_difference
from lagrangian_in_numbers import LagrangianModel
from urdf_variants import DOOR, VEHICLE, robot_data_vehicle, write_arm_of

from doorman.kinematics.coupling import Coupling
from doorman.kinematics.doors.door import Door
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.scenario import DoorSection

RESISTING = DoorSection(damping=0.4, friction=0.6, stiffness=1.5, rest_angle=1.2)


@pytest.fixture(scope="module", params=["paper", "borinot_flying_arm_2", "hextilt_flying_arm_5", 1, 3, 7])
def lagrangian(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> LagrangianModel:
    kind = request.param
    if kind == "paper":
        vehicle = Vehicle(VEHICLE)
    elif isinstance(kind, int):
        path: Path = tmp_path_factory.mktemp("arm") / "odd.urdf"
        vehicle = Vehicle(write_arm_of(path, kind, odd_axes_seed=kind))
    else:
        vehicle = Vehicle(*robot_data_vehicle(kind))
    return LagrangianModel(Coupling(vehicle, Door(DOOR, RESISTING), 0.7, 0.8), 0.02, disturbance=0.3)


def random_point(model: LagrangianModel, rng: np.random.Generator) -> np.ndarray:
    """State and input in one vector."""
    attitude, angle, rates = rng.uniform(-0.9, 0.9, 3), rng.uniform(0.0, 1.6, 1), rng.normal(size=4)
    thrust, torque = rng.uniform(5.0, 48.0, 1), rng.uniform(-1.0, 1.0, 3)
    arm, arm_rates = rng.uniform(-1.2, 1.2, model.n_arm), rng.uniform(-2.0, 2.0, model.n_arm)
    return np.concatenate([attitude, angle, rates, arm, thrust, torque, arm_rates])


def test_sensitivities_of_a_step(lagrangian: LagrangianModel, rng: np.random.Generator) -> None:
    nx = lagrangian.nx
    for _ in range(5):
        z = random_point(lagrangian, rng)
        by_state, by_input = lagrangian.step_jacobian(z[:nx], z[nx:])
        assert by_state.shape == (nx, nx)
        assert by_input.shape == (nx, lagrangian.nu)
        numeric = central_difference(lambda z: lagrangian.step(z[:nx], z[nx:]), z)
        error = np.hstack([by_state, by_input]) - numeric
        assert np.abs(error).max() < 1e-8 * max(1.0, np.abs(numeric).max())


def test_a_step_is_of_fourth_order(rng: np.random.Generator) -> None:
    """The error over 0.2 s falls by 2⁴ when the step is halved; the truth is a step 16 times finer than the finest."""
    coupling = Coupling(Vehicle(VEHICLE), Door(DOOR, RESISTING), 0.7, 0.8)
    start = np.concatenate([[0.1, -0.2, -0.3, 1.2], [0.4, -0.3, 0.5, -0.3], [0.1, 0.9, -0.6, -0.3]])
    u = np.concatenate([[31.0], [0.05, -0.04, 0.06], [0.3, -0.4, 0.2, 0.5]])

    def end(steps: int) -> np.ndarray:
        model, x = LagrangianModel(coupling, 0.2 / steps), start
        for _ in range(steps):
            x = model.step(x, u)
        return x

    truth = end(640)
    errors = [np.abs(end(steps) - truth).max() for steps in (10, 20, 40)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, 4.0, atol=0.25)
