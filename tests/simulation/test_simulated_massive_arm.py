"""A simulated arm with mass: the plant weighs what Pinocchio says, its servos carry their links, and slip beyond their limits."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from urdf_variants import write_massive

from doorman.feasibility.lift import weight_on_joints

MASSES = {"servo_1": 0.1, "servo_2": 0.15, "servo_3": 0.15, "servo_4": 0.2}


@pytest.fixture
def massive(flight, tmp_path: Path):
    """0.6 kg on the arm, in free flight."""
    path = write_massive(tmp_path / "arm.urdf", MASSES)
    return flight(vehicle__urdf=str(path), contact__kind="push", away=True)


def test_servos_hold_the_arms_weight(massive) -> None:
    massive.command(massive.model.vehicle.mass * 9.81)
    truth = massive.run(1.0, every=1000)[-1]
    np.testing.assert_allclose(truth.arm_angles, massive.model.start_arm, atol=5e-3)
    state = np.concatenate([truth.attitude, [0.0, 0.0], truth.arm_angles])
    expected = weight_on_joints(massive.model, state)
    torques = massive.data.qfrc_actuator[massive.plant.arm_velocities]
    assert np.abs(expected).max() > 0.5
    np.testing.assert_allclose(torques, expected, atol=0.02)


def test_a_servo_that_is_too_weak_slips(flight, tmp_path: Path) -> None:
    strong = write_massive(tmp_path / "arm.urdf", MASSES)
    text = strong.read_text(encoding="utf-8").replace('effort="3.1"', 'effort="0.3"')
    weak = tmp_path / "weak.urdf"
    weak.write_text(text, encoding="utf-8")
    vehicle = flight(vehicle__urdf=str(weak), contact__kind="push", away=True)
    vehicle.command(vehicle.model.vehicle.mass * 9.81)
    fallen = vehicle.run(0.4, every=400)[-1].arm_angles - vehicle.model.start_arm
    assert np.abs(fallen).max() > 0.1
    assert np.abs(vehicle.data.qfrc_actuator[vehicle.plant.arm_velocities]).max() < 0.31
