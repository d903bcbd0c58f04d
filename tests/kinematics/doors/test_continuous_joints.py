"""Doors whose joint is continuous: one turn about closed, and no stop in the simulation."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from urdf_variants import write_edited

from doorman.kinematics.doors.door import Door
from doorman.model import Model
from doorman.resources import urdf_directory
from doorman.scenario import DoorSection, Scenario
from doorman.simulation import Simulator

HANDLES = urdf_directory() / "door_with_handle.urdf"
SECTION = Model("shipped:pull").scenario.door


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
