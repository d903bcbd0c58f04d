"""The arm stays on its side of the rotors' plane: below them, or above them where it is mounted there."""

from __future__ import annotations

import re
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from urdf_variants import write_arm_of

from doorman.collision.constraints import collision_constraints
from doorman.dynamics.quasi_static import QuasiStaticTask
from doorman.kinematics.doors.door import Door
from doorman.kinematics.task_numbers import task_numbers
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.resources import urdf_directory

MARGIN = 0.02


@pytest.fixture(params=[(joints, height) for joints in (0, 1, 4) for height in (0.2, -0.05)])
def vehicle(request: pytest.FixtureRequest, tmp_path: Path) -> Vehicle:
    joints, height = request.param
    text = write_arm_of(tmp_path / "arm.urdf", joints).read_text(encoding="utf-8")
    first = "eta_1" if joints else "tip_mount"
    lifted, count = re.subn(
        rf'(<joint name="{first}".*?xyz="\S+ \S+ )[^"]*"', rf'\g<1>{height}"', text, count=1, flags=re.DOTALL
    )
    assert count == 1
    path = tmp_path / "lifted.urdf"
    path.write_text(lifted, encoding="utf-8")
    return Vehicle(path)


def test_an_arm_stays_on_its_side_of_the_rotors(vehicle: Vehicle, rng: np.random.Generator) -> None:
    root = (vehicle.arm.links if vehicle.n_arm else vehicle.arm.point_offsets)[0]
    above = root[2] > 0.0
    assert vehicle.arm.above == above
    pattern, _ = ArmPattern.of(vehicle.arm)
    numbers = task_numbers(vehicle, Door(urdf_directory() / "hinged_door.urdf"), 0.7, 0.8)
    task = QuasiStaticTask(pattern, vehicle.point_names, numbers)
    rows = collision_constraints(task, MARGIN, ("arm",))
    assert [row.name for row in rows] == [
        f"{name} {'above' if above else 'below'} body" for name in vehicle.point_names
    ]
    h = ca.Function("h", [task.state, task.parameters], [ca.vertcat(*(row.expression for row in rows))])
    for posture in rng.uniform(-1.5, 1.5, (5, vehicle.n_arm)):
        heights = vehicle.point_positions(posture)[:, 2]
        expected = MARGIN + (-heights if above else heights)
        if not vehicle.n_arm:
            expected = np.array([-1.0])  # a stick is never in its own body's way
        found = np.array(h(np.concatenate([np.zeros(5), posture]), numbers.vector)).ravel()
        np.testing.assert_allclose(found, expected, atol=1e-14)
