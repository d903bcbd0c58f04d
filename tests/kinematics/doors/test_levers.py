"""Levers, knobs and valves: they turn in the plane of the face that they stand on, however a URDF writes them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from doorman import Model, Scenario
from doorman.kinematics.doors.door import Door
from doorman.kinematics.doors.reading import read_door
from doorman.scenario import DoorSection
from doorman.stages import stages

_WALL = '<collision><origin xyz="0.1 0 1"/><geometry><box size="0.08 3 2"/></geometry></collision>'
_BAR = '<collision><origin xyz="{along}" rpy="{turned}"/><geometry><box size="0.16 0.02 0.014"/></geometry></collision>'
_KNOB = '<collision><geometry><cylinder radius="0.05" length="0.04"/></geometry></collision>'


def write_lever(
    path: Path, axis: str, shape: str, rpy: str = "0 0 0", wall: str = _WALL, tip: str = "0.12 0 0", limits: str = ""
) -> Path:
    """A mechanism before a wall whose face is at x = 0.06; the joint is at (0, 0.3, 1.1)."""
    kind = "revolute" if limits else "continuous"
    path.write_text(f"""<robot name="lever"><link name="base">{wall}</link>
<joint name="turn" type="{kind}"><origin xyz="0 0.3 1.1" rpy="{rpy}"/><parent link="base"/><child link="part"/>
<axis xyz="{axis}"/>{limits}</joint>
<link name="part"><inertial><origin xyz="0.02 0 0"/><mass value="0.3"/>
<inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial>{shape}</link>
<link name="grip"/><joint name="grip_joint" type="fixed"><origin xyz="{tip}"/><parent link="part"/><child link="grip"/>
</joint></robot>""")
    return path


BAR = _BAR.format(along="0.07 0 0", turned="0 0 0")
LIMIT = '<limit lower="{}" upper="{}" effort="1" velocity="1"/>'
LEVERS = {
    # the joint's z axis out of the wall, its x axis along the wall, up or down
    "lever": ("0 0 1", BAR, "0 -1.5707963 0", LIMIT.format(0, 0.8)),
    "turns the other way": ("0 0 -1", BAR, "0 1.5707963 0", LIMIT.format(-0.8, 0)),
    "valve": ("0 0 1", BAR, "0 -1.5707963 0", ""),
    "knob": ("0 0 1", _KNOB, "0 -1.5707963 0", LIMIT.format(-1.2, 1.2)),
}


@pytest.fixture(params=LEVERS)
def model(request: pytest.FixtureRequest, tmp_path: Path) -> Model:
    axis, shape, rpy, limits = LEVERS[request.param]
    tip = "0.05 0 0" if shape is _KNOB else "0.12 0.007 0"
    file = write_lever(tmp_path / "lever.urdf", axis, shape, rpy, tip=tip, limits=limits)
    door = {"urdf": str(file), "hinge": "turn", "leaf": "part"}
    return Model(Scenario(door=door, contact={"frame": "grip"}, goal={"opening": 0.6}))


def test_the_tip_follows_the_arc(model: Model) -> None:
    """Against Pinocchio's own kinematics of the joint."""
    plain = pinocchio.buildModelFromUrdf(str(model.door.urdf))
    data, frame, step = plain.createData(), plain.getFrameId("grip"), 1e-6
    assert model.door.in_plane
    for angle in np.linspace(model.start_angle, model.goal_angle, 5):
        for shift in (0.0, step):
            value = model.door.joint_value(angle + shift)
            places = [math.cos(value), math.sin(value)] if plain.nq == 2 else [value]
            pinocchio.framesForwardKinematics(plain, data, np.array(places))
            np.testing.assert_allclose(
                model.coupling.contact_point(angle + shift), data.oMf[frame].translation, atol=2e-9
            )
        moved = model.coupling.contact_point(angle + step) - model.coupling.contact_point(angle)
        lever = model.door.lever(angle, model.coupling.distance_from_hinge)
        np.testing.assert_allclose(lever, moved / step, atol=1e-6)
        assert float(lever @ model.door.up) == pytest.approx(0.0, abs=1e-9)


def test_the_vehicle_looks_at_the_wall_and_stays_before_it(model: Model) -> None:
    np.testing.assert_allclose(model.door.up, [-1.0, 0.0, 0.0], atol=1e-6)
    assert model.door.heading(model.goal_angle) == pytest.approx(0.0, abs=1e-6)
    np.testing.assert_allclose(model.hover_offset, [-model.scenario.mission.hover_distance, 0.0, 0.0], atol=1e-6)
    row = model.constraint_names.index("disc clear of panel")
    place = model.coupling.vehicle_position(model.start_state[:3], model.start_angle, model.start_arm)
    assert model.constraints(model.start_state)[row] == pytest.approx(place[0] + model.vehicle.radius - 0.06, abs=1e-6)


def test_without_a_wall_it_is_read_from_its_shape(tmp_path: Path) -> None:
    file = write_lever(tmp_path / "lever.urdf", "0 0 1", _KNOB, "0 -1.5707963 0", wall="")
    scenario = Scenario(door={"urdf": str(file), "hinge": "turn", "leaf": "part"}, goal={"opening": 0.5})
    assert read_door(scenario).in_plane


@pytest.mark.parametrize("task", ["hatch", "cabinet", "pull", "push_left"])
def test_doors_are_none(task: str) -> None:
    assert not Model(task).door.in_plane


def test_the_leaf_stands_and_the_lever_stays_turned() -> None:
    """The second step's contact is where the first one has left the tip."""
    lever, leaf = stages(Scenario.load("lever_pull"))
    assert (lever.door.section.hinge, leaf.door.section.hinge) == ("lever", "hinge")
    np.testing.assert_allclose(
        leaf.coupling.contact_point(leaf.start_angle), lever.coupling.contact_point(lever.goal_angle), atol=1e-9
    )
    assert leaf.scenario.mission.start == "contact" and lever.scenario.mission.then == "stay"
    np.testing.assert_allclose(leaf.start_arm, lever.goal_arm)


def test_the_same_way_of_the_tip_turns_a_lever_farther() -> None:
    lever, leaf = stages(Scenario.load("lever_pull"))
    assert leaf.turn_scale == 1.0
    assert lever.turn_scale == pytest.approx(Model("paper").coupling.lever_length / lever.coupling.lever_length)


def test_a_lever_on_a_leaf_needs_a_latch_that_it_opens() -> None:
    urdf = Scenario.load("lever_pull").door_urdf
    with pytest.raises(Exception, match="lever"):
        Door(urdf, DoorSection())
    assert Door(urdf, DoorSection(latch={"joint": "lever", "opens_at": 0.5})).standing_joints == ()
