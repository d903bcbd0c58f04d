"""Collision shapes, joints and link tree read from the XML against yourdfpy, which reads the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from urdf_parser import load_description
from urdf_variants import DOOR, VEHICLE, robot_data_vehicle, write_door, write_edited

from doorman.kinematics.urdf.elements import link_name, read_collisions, read_joints, read_parents

MESH = '<mesh filename="disc.stl" scale="0.5 1 2"/>'


@pytest.fixture(params=["vehicle", "door", "heavy door", "mimic", "mesh and ball", "borinot"])
def urdf(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    if request.param == "heavy door":
        return write_door(tmp_path / "door.urdf", mass=20.0, damping=0.4, friction=0.8)
    if request.param == "mimic":
        joint = '<joint name="hinge" type="revolute">'
        absent = (('<axis xyz="0 0 1"/>', ""), ('<dynamics damping="0.0" friction="0.0"/>', ""))
        return write_edited(tmp_path / "door.urdf", DOOR, (joint, f'{joint}<mimic joint="other"/>'), *absent)
    if request.param == "mesh and ball":
        ball = (
            '<collision name="ball"><origin rpy="0.1 -0.2 0.3"/><geometry><sphere radius="0.1"/></geometry></collision>'
        )
        disc = '<cylinder radius="0.40" length="0.0004"/></geometry>\n    </collision>'
        return write_edited(tmp_path / "edited.urdf", VEHICLE, (disc, f"{MESH}</geometry></collision>{ball}"))
    if request.param == "borinot":
        return robot_data_vehicle("borinot_flying_arm_2")[0]
    return {"vehicle": VEHICLE, "door": DOOR}[request.param]


def test_shapes_are_those_that_yourdfpy_reads(urdf: Path) -> None:
    theirs = [(name, one) for name, link in load_description(urdf).link_map.items() for one in link.collisions]
    ours = read_collisions(urdf)
    assert len(ours) == len(theirs) > 0
    assert len({shape.name for shape in ours}) == len(ours)
    for mine, (link, other) in zip(ours, theirs, strict=True):
        geometry = other.geometry
        assert mine.link == link
        np.testing.assert_allclose(mine.placement, np.eye(4) if other.origin is None else other.origin, atol=1e-12)
        if geometry.box is not None:
            assert (mine.kind, mine.size) == ("box", tuple(geometry.box.size))
        elif geometry.cylinder is not None:
            assert (mine.kind, mine.size) == ("cylinder", (geometry.cylinder.radius, geometry.cylinder.length))
        elif geometry.sphere is not None:
            assert (mine.kind, mine.size) == ("sphere", (geometry.sphere.radius,))
        else:
            scale = np.ones(3) if geometry.mesh.scale is None else geometry.mesh.scale
            assert (mine.kind, mine.file) == ("mesh", geometry.mesh.filename)
            np.testing.assert_array_equal(mine.size, np.broadcast_to(scale, 3))


def test_the_tree_is_the_one_that_yourdfpy_reads(urdf: Path) -> None:
    joints = load_description(urdf).robot.joints
    assert read_parents(urdf) == {joint.child: (joint.name, joint.parent) for joint in joints}
    assert link_name(urdf, joints[0].child) == joints[0].child
    assert link_name(urdf, joints[0].name) == joints[0].child


def test_joints_are_those_that_yourdfpy_reads(urdf: Path) -> None:
    ours, theirs = read_joints(urdf), load_description(urdf).joint_map
    assert list(ours) == list(theirs)
    for name, joint in theirs.items():
        mine = ours[name]
        assert (mine.name, mine.child, mine.axis) == (name, joint.child, tuple(joint.axis))
        assert mine.effort == (0.0 if joint.limit is None else joint.limit.effort)
        for field in ("damping", "friction"):
            assert getattr(mine, field) == float(getattr(joint.dynamics, field, None) or 0.0)
        assert mine.leader == (None if joint.mimic is None else joint.mimic.joint)
