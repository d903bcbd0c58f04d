"""The planner's simplified dynamics: an independent formulation, derivatives, and order of convergence."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from attitude_matrices import euler_rate_matrix
from finite_differences import central_difference
from paper_door import door_normal
from urdf_variants import write_arm_of

from doorman.exceptions import DimensionError, SingularityError
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.scenario import DoorSection, Scenario, VehicleSection

RESISTING = DoorSection(damping=0.4, friction=0.6, stiffness=1.5, rest_angle=1.2)


@pytest.fixture(
    scope="module", params=[4, 1, pytest.param(2, marks=pytest.mark.slow), pytest.param(7, marks=pytest.mark.slow)]
)
def any_model(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Model:
    """A door that resists, arms of several lengths."""
    path: Path = tmp_path_factory.mktemp("arm") / "vehicle.urdf"
    vehicle = VehicleSection() if request.param == 4 else VehicleSection(urdf=str(write_arm_of(path, request.param)))
    return Model(Scenario(vehicle=vehicle, door=RESISTING))


def random_point(model: Model, rng: np.random.Generator) -> np.ndarray:
    """State and input in one vector."""
    n = model.n_arm
    state = [rng.uniform(-1.0, 1.0, 3), rng.uniform(0.0, 1.6, 1), rng.normal(size=1), rng.uniform(-1.5, 1.5, n)]
    return np.concatenate([*state, rng.uniform(5.0, 48.0, 1), rng.normal(size=3), rng.uniform(-3.0, 3.0, n)])


def plain_derivative(model: Model, x: np.ndarray, u: np.ndarray, disturbance: float = 0.0) -> np.ndarray:
    """The equations as they stand in the paper, with matrices: F_R from thrust and weight, its share along n_D."""
    force = u[0] * rotation_body_to_world(x[:3])[:, 2] - [0.0, 0.0, model.vehicle.mass * 9.81]
    torque = -model.coupling.distance_from_hinge * door_normal(x[3]) @ force
    torque -= model.door.hinge_torque(x[3], x[4]) + disturbance
    return np.concatenate([euler_rate_matrix(x[:3]) @ u[1:4], x[4:5], [torque / model.door.inertia], u[4:]])


def plain_step(model: Model, x: np.ndarray, u: np.ndarray, h: float) -> np.ndarray:
    k1 = plain_derivative(model, x, u)
    k2 = plain_derivative(model, x + 0.5 * h * k1, u)
    k3 = plain_derivative(model, x + 0.5 * h * k2, u)
    k4 = plain_derivative(model, x + h * k3, u)
    return x + h / 6.0 * (k1 + 2 * k2 + 2 * k3 + k4)


def test_step_equals_its_plain_twin(any_model: Model, rng: np.random.Generator) -> None:
    for _ in range(10):
        z = random_point(any_model, rng)
        x, u = z[: any_model.nx], z[any_model.nx :]
        np.testing.assert_allclose(any_model.step(x, u), plain_step(any_model, x, u, 0.02), rtol=1e-13, atol=1e-14)


def test_sensitivities_of_a_step(any_model: Model, rng: np.random.Generator) -> None:
    nx = any_model.nx
    for _ in range(10):
        z = random_point(any_model, rng)
        by_state, by_input = any_model.step_jacobian(z[:nx], z[nx:])
        assert by_state.shape == (nx, nx)
        assert by_input.shape == (nx, any_model.nu)
        numeric = central_difference(lambda z: any_model.step(z[:nx], z[nx:]), z)
        np.testing.assert_allclose(np.hstack([by_state, by_input]), numeric, atol=2e-9)


def test_a_vehicle_that_leans_forward_opens_the_door_by_hand(model: Model) -> None:
    """Nose down by 0.1 rad before the closed door: α̈ = −(D_V/I_D) f_t sin 0.1."""
    x = model.start_state.copy()
    x[1] = 0.1
    expected = -(0.7 / 5.28) * 29.43 * math.sin(0.1)
    assert model.derivative(x, model.hover_input)[4] == pytest.approx(expected, rel=1e-12)


def test_a_disturbance_brakes_the_door(model: Model) -> None:
    braked = model.reduced.with_numbers({"door.disturbance": 0.528})
    assert braked.derivative(model.start_state.copy(), model.hover_input.copy())[4] == pytest.approx(-0.1)
    assert model.derivative(model.start_state, model.hover_input)[4] == pytest.approx(0.0, abs=1e-15)


def test_the_singularity_is_an_error(model: Model) -> None:
    x = model.start_state.copy()
    x[1] = math.pi / 2
    for method in (model.derivative, model.step, model.step_jacobian):
        with pytest.raises(SingularityError, match="pitch"):
            method(x, model.hover_input)


@pytest.mark.parametrize("method", ["derivative", "step", "step_jacobian"])
def test_what_is_not_a_state_or_an_input_is_an_error(model: Model, method: str) -> None:
    with pytest.raises(DimensionError, match="state"):
        getattr(model, method)(model.start_state[1:], model.hover_input)
    with pytest.raises(DimensionError, match=r"state\[4\]"):
        getattr(model, method)([0, 0, 0, 0, math.nan, 0, 0, 0, 0], model.hover_input)
    with pytest.raises(DimensionError, match="inputs"):
        getattr(model, method)(model.start_state, model.hover_input[1:])
