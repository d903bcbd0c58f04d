"""A door that truly stands elsewhere, or whose face does: where its parts are, against geometry by hand."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from urdf_variants import DOOR, write_edited

from doorman.collision.shapes import read_shapes
from doorman.kinematics.doors.door import Door
from doorman.kinematics.doors.variants.true_door import TrueDoor, is_another
from doorman.model import Model
from doorman.scenario import DoorSection, Scenario, SimulationSection

OFFSET, YAW = (0.03, -0.02, 0.01), 0.07


def true_door(urdf: Path = DOOR, section: DoorSection | None = None, **true: object) -> TrueDoor:
    return TrueDoor(urdf, section or DoorSection(), SimulationSection(**true))


def corner_of_leaf(door: Door, angle: float) -> np.ndarray:
    """Of the leaf's box: at the latch, on the vehicle's side, above, world frame [m]."""
    (box,) = [shape for shape in read_shapes(door.urdf) if shape.link == "leaf"]
    placement = door.link_placements(angle)["leaf"] @ box.placement
    return placement[:3, :3] @ box.half_extents + placement[:3, 3]


@pytest.mark.parametrize("angle", [math.pi / 2, 0.6])
def test_leaf_and_frame_stand_where_offset_and_yaw_put_them(angle: float) -> None:
    door = true_door(door_offset=OFFSET, door_yaw=YAW)
    along = np.array([math.cos(angle + YAW), math.sin(angle + YAW), 0.0])
    expected = np.array([0.03, -0.02, 0.41]) + 1.2 * along + [0.0, 0.0, 1.6]
    np.testing.assert_allclose(corner_of_leaf(door, angle), expected, atol=1e-9)
    np.testing.assert_allclose(door.contact_point(angle, 0.7, 0.8), [0.03, -0.02, 1.21] + 0.7 * along, atol=1e-12)
    frame = door.link_placements(angle)["frame"]
    latch = frame @ [0.0, 1.2, 0.4, 1.0]  # of the doorway, level with the hinge line's lower end
    np.testing.assert_allclose(latch[:3], [0.03 - 1.2 * math.sin(YAW), -0.02 + 1.2 * math.cos(YAW), 0.41], atol=1e-12)


@pytest.mark.parametrize("face", [0.04, -0.015])
def test_the_whole_leaf_stands_before_the_axis(face: float) -> None:
    door, plain = true_door(door_face_offset=face), Door(DOOR)
    assert door.surface_offset == pytest.approx(face)
    for angle in (math.pi / 2, 0.6):
        before = np.array([-math.sin(angle), math.cos(angle), 0.0])
        np.testing.assert_allclose(
            corner_of_leaf(door, angle) - corner_of_leaf(plain, angle), face * before, atol=1e-12
        )
    assert door.inertia == pytest.approx(plain.inertia + 11.0 * face**2)  # Steiner: its mass moves along
    assert door.mass == plain.mass and door.width == plain.width and door.upper_limit == plain.upper_limit


def test_the_face_is_where_it_is_asked_for_whatever_the_urdf_says(tmp_path: Path) -> None:
    proud = write_edited(tmp_path / "proud.urdf", DOOR, ('name="hinge" type="revolute">\n    <origin xyz="0 0 0.4"',
                         'name="hinge" type="revolute">\n    <origin xyz="0.1 0.2 0.4"'))  # fmt: skip
    text = proud.read_text(encoding="utf-8")
    proud.write_text(text.replace('xyz="0.6 -0.02 0.8"', 'xyz="0.6 0.01 0.8"'), encoding="utf-8")
    assert Door(proud).surface_offset == pytest.approx(0.03)
    for face in (0.0, 0.03, 0.05):
        assert true_door(proud, door_face_offset=face).surface_offset == pytest.approx(face)


def test_all_at_once_and_of_another_width() -> None:
    door = true_door(section=DoorSection(width=1.1, mass=8.0), door_width=1.3, door_face_offset=0.02, door_offset=OFFSET,
                     door_yaw=YAW)  # fmt: skip
    assert (door.width, door.mass) == (pytest.approx(1.3), pytest.approx(8.0))
    assert door.inertia == pytest.approx(8.0 * 1.3**2 / 3.0 + 8.0 * 0.02**2, rel=1e-6)
    along, before = (
        np.array([math.cos(1.0 + YAW), math.sin(1.0 + YAW), 0]),
        [-math.sin(1.0 + YAW), math.cos(1.0 + YAW), 0],
    )
    expected = np.array([0.03, -0.02, 2.01]) + 1.3 * along + 0.02 * np.array(before)
    np.testing.assert_allclose(corner_of_leaf(door, 1.0), expected, atol=1e-9)


def test_a_leaf_that_a_link_carries_moves_with_its_carrier(tmp_path: Path) -> None:
    """The hinge may carry a link on which the leaf hangs, turned about the vertical."""
    text = DOOR.read_text(encoding="utf-8").replace('<child link="leaf"/>', '<child link="strap"/>')
    weld = (
        '<link name="strap"/><joint name="weld" type="fixed"><origin xyz="0 0 0.1" rpy="0 0 0.5"/>'
        '<parent link="strap"/><child link="turned"/></joint><link name="turned"/><joint name="back" type="fixed">'
        '<origin xyz="0 0 -0.1" rpy="0 0 -0.5"/><parent link="turned"/><child link="leaf"/></joint></robot>'
    )
    path = tmp_path / "strap.urdf"
    path.write_text(text.replace("</robot>", weld), encoding="utf-8")
    door = true_door(path, door_face_offset=0.04)
    np.testing.assert_allclose(
        corner_of_leaf(door, 0.6), corner_of_leaf(true_door(door_face_offset=0.04), 0.6), atol=1e-9
    )


def test_meshes_of_a_moved_leaf_are_found(tmp_path: Path) -> None:
    """They are named relative to the URDF that was written by hand."""
    (tmp_path / "knob.stl").write_bytes(b"solid knob")
    knob = '<visual name="knob"><geometry><mesh filename="knob.stl"/></geometry></visual>'
    path = write_edited(tmp_path / "door.urdf", DOOR, ('<link name="leaf">', f'<link name="leaf">{knob}'))
    (mesh,) = ElementTree.parse(true_door(path, door_face_offset=0.04).urdf).iter("mesh")
    assert mesh.get("filename") == str(tmp_path.resolve() / "knob.stl")


def test_planner_and_check_believe_the_scenarios_door() -> None:
    told = Model(Scenario.load("push"))
    other = Model(
        Scenario.load(
            "push", {"simulation.door_offset": OFFSET, "simulation.door_yaw": YAW, "simulation.door_face_offset": 0.04}
        )
    )
    assert told.true_door is told.door and isinstance(other.true_door, TrueDoor)
    np.testing.assert_array_equal(other.reduced.numbers.vector, told.reduced.numbers.vector)
    np.testing.assert_array_equal(other.goal_state, told.goal_state)
    np.testing.assert_array_equal(other.door.hinge_position, told.door.hinge_position)


def test_what_is_not_given_is_the_door_that_is_told() -> None:
    assert not is_another(SimulationSection(door_mass=7.0, door_offset=(0.0, 0.0, 0.0), door_yaw=0.0))
    for other in ({"door_offset": (0.0, 0.0, 0.1)}, {"door_yaw": -0.1}, {"door_face_offset": 0.0}, {"door_width": 1.3}):
        assert is_another(SimulationSection(**other))
