"""The stepping kernel against a plain twin: the same loop in Python with MuJoCo's own binding, and NumPy's formulas."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from attitude_matrices import skew

from doorman.kinematics.rotations import attitude_from_rotation
from doorman.simulation.plant.gripper import ContactReader
from doorman.simulation.plant.onboard.step import onboard_step
from doorman.simulation.plant.stepping import STANDS


def plain_steps(one, steps: int) -> dict[str, np.ndarray]:
    """The physics step by step in Python; forces of tip on leaf, and others' pairs, read contact by contact."""
    simulator, data, plant = one.simulator, one.data, one.plant
    own, frictions, hinge = simulator._own, plant.engine_model.dof_frictionloss, plant.hinge_velocity
    reader = ContactReader(mujoco, plant, simulator._gripper)
    forces, along, others = [], [], 0
    for _ in range(steps):
        onboard_step(own.onboard, data.qpos[3:7], data.qvel[3:6], data.qpos, data.qvel, data.ctrl)
        torque, friction, stiction = own.hinge.torque, own.hinge.friction, own.hinge.stiction
        data.qfrc_applied[hinge] = torque
        if stiction > 0.0:
            frictions[hinge] = friction + (stiction if abs(data.qvel[hinge]) < STANDS else 0.0)
        normal = plant.hinge.normal(plant.door_angle)
        mujoco.mj_step(plant.engine_model, data)
        read = reader.read()
        forces.append(read.tip)
        along.append(float(normal @ read.tip))
        others = max(others, len(read.others))
    return {
        "qpos": data.qpos.copy(), "qvel": data.qvel.copy(), "force": forces[-1],
        "sums": np.array([along[-1], max(0.0, *(-np.array(along))), max(0.0, *along)]), "others": np.array(others),
    }  # fmt: skip


def stepped(one, steps: int) -> dict[str, np.ndarray]:
    one.simulator.advance(steps)
    noted, truth = one.simulator._noted, one.simulator.truth()
    found = {
        "qpos": one.data.qpos.copy(),
        "qvel": one.data.qvel.copy(),
        "force": noted.force.copy(),
        "sums": np.array([noted.along, noted.max_pull, noted.max_push]),
    }
    return found | {"others": np.array(truth.collisions)}


FLIGHTS = {
    "gripping": ({"simulation__door_stiction": 2.0}, (3.0, 0.0), 1e-9),
    "pushing": ({"contact__kind": "push"}, (6.0, 0.2), 1e-9),
    "away": ({"contact__kind": "push", "away": True}, (-2.0, 0.0), 1e-9),
    "into the leaf": ({"contact__kind": "push"}, (25.0, 1.0), 1e-3),  # a crash makes much of the last bits
}
"""Overrides, force [N] and speed [m/s] with which it begins, and by how much the twins may differ."""


@pytest.mark.parametrize("name", FLIGHTS)
def test_it_flies_and_feels_as_its_plain_twin(flight, name):
    overrides, (force, speed), most = FLIGHTS[name]
    plain, fast = flight(**overrides), flight(**overrides)
    for one in (plain, fast):
        one.lean(force)
        one.data.qvel[0] = speed
    touched = 0
    for steps in (1, 7, 4, 60, 200, 128):
        expected, found = plain_steps(plain, steps), stepped(fast, steps)
        for key, value in expected.items():
            np.testing.assert_allclose(found[key], value, atol=most, err_msg=f"{key} after {steps} steps")
        touched += int(expected["others"])
        if touched:
            break  # from the crash on, the last bits decide, and with them the processor
    assert (touched > 0) == (name == "into the leaf")


@pytest.mark.parametrize("kind", ["grip", "push"])
def test_what_it_sees_is_what_numpy_works_out(flight, kind):
    vehicle = flight(contact__kind=kind)
    vehicle.data.qpos[3:7] = np.array([0.8, -0.3, 0.2, 0.45]) / np.linalg.norm([0.8, -0.3, 0.2, 0.45])
    vehicle.data.qvel[:6] = 0.3, -0.2, 0.1, 0.7, -0.4, 0.9
    truth, to_base = vehicle.simulator.truth(), vehicle.plant.root_to_base
    root = np.empty(9)
    mujoco.mju_quat2Mat(root, vehicle.data.qpos[3:7])
    root = root.reshape(3, 3)
    spin, place = vehicle.data.qvel[3:6], to_base[:3, 3]
    np.testing.assert_allclose(truth.position, vehicle.data.qpos[:3] + root @ place, atol=1e-14)
    np.testing.assert_allclose(truth.velocity, vehicle.data.qvel[:3] + root @ skew(spin) @ place, atol=1e-14)
    np.testing.assert_allclose(truth.attitude, attitude_from_rotation(root @ to_base[:3, :3]), atol=1e-14)
    np.testing.assert_allclose(truth.body_rates, to_base[:3, :3].T @ spin, atol=1e-14)
    np.testing.assert_array_equal(truth.arm_angles, vehicle.data.qpos[vehicle.plant.arm_positions])
    np.testing.assert_array_equal(truth.arm_rates, vehicle.data.qvel[vehicle.plant.arm_velocities])
    assert not truth.attitude.flags.writeable


def test_ticks_are_as_their_steps(flight):
    """What a tick tells is what its steps did, also where others than tip and leaf touch in the middle of it."""
    once, often = flight(contact__kind="push"), flight(contact__kind="push")
    for one in (once, often):
        one.lean(20.0)
        one.data.qvel[0] = 1.0
    truths = often.run(0.6)
    once.simulator.advance(len(truths))
    whole = once.simulator.truth()
    assert whole.max_push == max(truth.max_push for truth in truths) > 0.0
    assert whole.collisions == max(truth.collisions for truth in truths) > 0
    assert set(whole.collision_pairs) == {pair for truth in truths for pair in truth.collision_pairs}
    np.testing.assert_array_equal(whole.position, truths[-1].position)
