"""The estimate's kernel against its equations in plain numpy, on a hinge, a slide, a flap and a lever."""

from __future__ import annotations

import numpy as np
import pytest
from attitude_matrices import body_rate_matrix, euler_rate_matrix
from believed import geometry

from doorman.control.estimation.estimator import Estimator, Tie
from doorman.model import Model
from doorman.signals import Measurement

AGE = 0.012


@pytest.mark.parametrize("name", ["push", "pull", "drawer", "hatch", "knob_valve"])
def test_an_estimate_is_the_last_pose_carried_on(name: str) -> None:
    model = Model(name)
    estimator, rng = Estimator(model), np.random.default_rng(3)
    attitude, rates = np.array([0.1, -0.2, model.start_yaw + 0.1]), np.array([0.3, -0.2, 0.4])
    arm, arm_rates = model.start_arm + 0.1, rng.uniform(-0.5, 0.5, model.n_arm)
    place = model.coupling.vehicle_position(attitude, model.start_angle, arm) + [0.05, -0.02, 0.03]
    for tick in range(20):
        seen = Measurement(
            0.004 * tick, place + 1e-3 * tick, np.zeros(3), attitude, rates, arm, arm_rates, 0.004 * tick - AGE
        )
        known = estimator.update(seen, Tie.PUSHING, False, 0.004)
    run = estimator.run
    assert run is not None
    bank, state = run.estimate, run.state
    gains = np.array([bank.outputs[f"gains_{axis}"][0] for axis in "xyz"])
    moves = state.velocity
    np.testing.assert_allclose(known.position, state.position + AGE * moves + 0.5 * AGE**2 * gains, atol=1e-12)
    np.testing.assert_allclose(known.velocity, moves + AGE * gains, atol=1e-12)
    angle = state.joint + AGE * state.joint_rate
    np.testing.assert_allclose(known.state[3:], [angle, state.joint_rate, *arm], atol=1e-12)
    np.testing.assert_allclose(known.attitude_rates, euler_rate_matrix(known.attitude) @ rates, atol=1e-12)
    for field, value in geometry(model, known.position, known.state).items():
        np.testing.assert_allclose(getattr(known, field), value, atol=1e-12, err_msg=field)
    turning = body_rate_matrix(known.attitude) @ [0.0, 0.0, known.attitude_rates[2]]
    tip, rate = model.coupling.door_state(known.position, known.velocity, known.attitude, turning, arm, arm_rates)
    assert known.tip_angle == pytest.approx(tip - model.coupling.angle_of_face(known.face_offset), abs=1e-12)
    assert known.tip_speed == pytest.approx(-model.coupling.lever_length * rate, abs=1e-12)
    along, up = known.friction_force
    force = known.normal_force * known.normal + along * known.along + up * model.door.up
    np.testing.assert_allclose(known.tip_force, force, atol=1e-12)
    assert known.normal_force == bank.outputs["normal_force"][0]
    np.testing.assert_array_equal(known.wind, [bank.outputs[f"wind_{axis}"][0] for axis in "xyz"])
