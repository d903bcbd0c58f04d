"""Door: what the URDF says, and the torques in the hinge."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from urdf_variants import DOOR, write_door, write_edited

from doorman.kinematics.doors.door import Door
from doorman.scenario import DoorSection


def test_numbers_of_the_shipped_door() -> None:
    door = Door(DOOR)
    assert door.inertia == pytest.approx(5.28, abs=1e-12)
    assert door.mass == pytest.approx(11.0, abs=1e-12)
    np.testing.assert_allclose([door.width, door.height, door.thickness], [1.2, 1.6, 0.04], atol=1e-12)
    assert door.surface_offset == pytest.approx(0.0, abs=1e-12)
    assert door.frame_depth == pytest.approx(0.12), "floor and lintel are no jambs"
    np.testing.assert_allclose(door.hinge_position, [0.0, 0.0, 0.4], atol=1e-15)
    assert (door.damping, door.friction, door.stiffness) == (0.0, 0.0, 0.0)
    assert door.lower_limit < 0.0 < math.pi / 2 < door.upper_limit


def test_a_box_may_be_turned_in_the_leaf(tmp_path: Path) -> None:
    old = '<origin xyz="0.6 -0.02 0.8" rpy="0 0 0"/>\n      <geometry><box size="1.2 0.04 1.6"/></geometry>\n    </collision>'
    new = old.replace('rpy="0 0 0"', 'rpy="0 1.5707963267948966 0"').replace("1.2 0.04 1.6", "1.6 0.04 1.2")
    door = Door(write_edited(tmp_path / "door.urdf", DOOR, (old, new)))
    np.testing.assert_allclose([door.width, door.height, door.thickness], [1.2, 1.6, 0.04], atol=1e-12)


def test_torques_come_from_the_urdf_unless_the_scenario_says_otherwise(tmp_path: Path) -> None:
    path = write_door(tmp_path / "door.urdf", damping=0.3, friction=0.7)
    assert (Door(path).damping, Door(path).friction) == (0.3, 0.7)
    told = Door(path, DoorSection(damping=0.0, friction=0.2))
    assert (told.damping, told.friction) == (0.0, 0.2)


def test_torques_may_be_left_out_of_the_urdf(tmp_path: Path) -> None:
    door = Door(write_edited(tmp_path / "door.urdf", DOOR, ('<dynamics damping="0.0" friction="0.0"/>', "")))
    assert (door.damping, door.friction) == (0.0, 0.0)


def test_hinge_torque_adds_damping_friction_and_spring() -> None:
    door = Door(DOOR, DoorSection(damping=0.4, friction=0.6, stiffness=2.0, rest_angle=1.0))
    assert door.hinge_torque(1.0, 0.0) == 0.0
    assert door.hinge_torque(1.3, 0.0) == pytest.approx(0.6)
    assert door.hinge_torque(1.0, 10.0) == pytest.approx(4.6)
    assert door.hinge_torque(1.0, -10.0) == pytest.approx(-4.6)
    assert door.hinge_torque(1.0, 0.02) == pytest.approx(0.4 * 0.02 + 0.6 * math.tanh(1.0))
