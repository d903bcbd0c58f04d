"""Door: what the URDF says, the torques in the hinge, where a leaf shuts no farther, and joints without an end."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from urdf_variants import DOOR, write_door, write_edited

from doorman.kinematics.doors.door import Door
from doorman.model import Model
from doorman.resources import urdf_directory
from doorman.scenario import DoorSection, Scenario
from doorman.simulation import Simulator

CLOSED = 0.5 * math.pi
HANDLES = urdf_directory() / "door_with_handle.urdf"
SECTION = Model("shipped:pull").scenario.door


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


@pytest.mark.parametrize(
    ("side", "lower", "upper", "stop"),
    [("push", -1.5, 1.5708, CLOSED), ("push", -1.5, 1.7, 1.7), ("pull", 1.45, 3.1, 1.45), ("pull", -1.5, 1.7, 1.442)],
)
def test_a_leaf_stops_where_its_joint_ends(
    side: Literal["push", "pull"], lower: float, upper: float, stop: float, tmp_path: Path
) -> None:
    text = '<limit lower="-1.5" upper="1.5708"'
    urdf = write_edited(tmp_path / "door.urdf", DOOR, (text, f'<limit lower="{lower}" upper="{upper}"'))
    door = Door(urdf, DoorSection(closed=CLOSED), side)
    assert door.stop == pytest.approx(stop, abs=1e-3)
    assert door.at_its_stop(stop) and door.at_its_stop(CLOSED) is (abs(stop - CLOSED) < 0.01)
    assert door.stop in (door.lower_limit, door.upper_limit)
    pressed = Door(urdf, DoorSection(closed=CLOSED, preload=1.0), side)
    assert pressed.at_its_stop(CLOSED) and pressed.stop in (pressed.lower_limit, pressed.upper_limit)


def test_a_joint_without_limits_has_no_stop_where_it_is_closed(tmp_path: Path) -> None:
    urdf = write_edited(tmp_path / "door.urdf", DOOR, ('type="revolute"', 'type="continuous"'))
    assert not Door(urdf, DoorSection(closed=CLOSED)).at_its_stop(CLOSED)


@pytest.fixture(scope="module")
def endless(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The shipped room door on a hinge without limits."""
    text = HANDLES.read_text(encoding="utf-8")
    joint = text[text.index('type="revolute"') : text.index("</joint>", text.index('type="revolute"'))]
    limit = joint[joint.index("<limit") : joint.index("/>", joint.index("<limit")) + 2]
    turning = joint.replace('type="revolute"', 'type="continuous"').replace(limit, "")
    return write_edited(tmp_path_factory.mktemp("door") / "endless.urdf", HANDLES, (joint, turning))


def test_it_is_the_revolute_door_with_a_range_of_one_turn(endless: Path) -> None:
    door, limited = Door(endless, SECTION), Door(HANDLES, SECTION)
    assert door.endless and not limited.endless
    assert door.closed == pytest.approx(limited.closed), "the jamb tells"
    assert (door.lower_limit, door.upper_limit) == pytest.approx((-0.5 * math.pi, 1.5 * math.pi))
    for angle in (0.3, math.pi / 2):
        np.testing.assert_allclose(
            door.contact_point(angle, 0.6, 0.9), limited.contact_point(angle, 0.6, 0.9), atol=1e-12
        )
        assert door.joint_value(angle) == pytest.approx(limited.joint_value(angle))


@pytest.mark.parametrize("closed", [-2.0, 0.4])
def test_the_scenario_says_where_it_is_closed(endless: Path, closed: float) -> None:
    door = Door(endless, SECTION.model_copy(update={"closed": closed}))
    assert door.joint_value(door.angle_of_opening(0.0)) == pytest.approx(closed)
    assert door.joint_value(door.angle_of_opening(1.0)) == pytest.approx(closed + 1.0)
    assert door.largest_opening == pytest.approx(math.pi)


def test_a_wheel_without_jambs_is_closed_at_zero(tmp_path: Path) -> None:
    wheel = tmp_path / "wheel.urdf"
    wheel.write_text(
        """<?xml version="1.0"?>
<robot name="wheel"><link name="frame"/>
<joint name="turn" type="continuous"><origin xyz="1 2 1"/><parent link="frame"/><child link="leaf"/><axis xyz="0 0 1"/></joint>
<link name="leaf"><inertial><origin xyz="0.3 0 0"/><mass value="2"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
<collision><origin xyz="0.3 0 0"/><geometry><box size="0.6 0.03 0.4"/></geometry></collision></link></robot>""",
        encoding="utf-8",
    )
    door = Door(wheel, DoorSection(hinge="turn", leaf="leaf"))
    assert door.closed == pytest.approx(0.0, abs=1e-9)


def test_nothing_stops_it_in_the_simulation(endless: Path) -> None:
    for urdf, limited in ((HANDLES, True), (endless, False)):
        plant = Simulator(Model(Scenario.load("shipped:pull", {"door.urdf": str(urdf)})), 1e-3).plant
        engine = plant.engine_model
        (hinge,) = [k for k in range(engine.njnt) if engine.joint(k).name.endswith(SECTION.hinge)]
        assert bool(engine.jnt_limited[hinge]) is limited
