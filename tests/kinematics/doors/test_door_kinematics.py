"""Door: what the URDF says, and the torques in the hinge."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from paper_door import door_normal, leaf_direction
from urdf_parser import load_description
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


@pytest.mark.parametrize(("width", "mass"), [(1.1, 6.0), (1.2, 11.0), (1.5, 20.0)])
def test_a_thin_plate_has_a_third_of_its_mass_at_its_edge(width: float, mass: float, tmp_path: Path) -> None:
    door = Door(write_door(tmp_path / "door.urdf", width=width, mass=mass, thickness=0.06, height=2.0))
    assert door.inertia == pytest.approx(mass * width**2 / 3.0, rel=1e-12)
    np.testing.assert_allclose([door.width, door.height, door.thickness], [width, 2.0, 0.06], atol=1e-12)
    assert door.surface_offset == pytest.approx(0.0, abs=1e-12)


def test_a_written_door_of_the_shipped_size_is_the_shipped_door(tmp_path: Path) -> None:
    written, shipped = load_description(write_door(tmp_path / "door.urdf")), load_description(DOOR)
    for name, link in shipped.link_map.items():
        for ours, theirs in zip(link.collisions, written.link_map[name].collisions, strict=True):
            np.testing.assert_allclose(ours.origin, theirs.origin, atol=1e-12)
            np.testing.assert_allclose(ours.geometry.box.size, theirs.geometry.box.size, atol=1e-12)


def test_jambs_of_a_written_door_stand_at_the_edges_of_its_leaf(tmp_path: Path) -> None:
    frame = load_description(write_door(tmp_path / "door.urdf", width=1.35)).link_map["frame"]
    faces = {shape.name: (shape.origin[1, 3], shape.geometry.box.size[1] / 2) for shape in frame.collisions}
    assert faces["jamb_hinge"][0] + faces["jamb_hinge"][1] == pytest.approx(0.0)
    assert faces["jamb_latch"][0] - faces["jamb_latch"][1] == pytest.approx(1.35)
    assert faces["wall_latch"][0] - faces["wall_latch"][1] == pytest.approx(1.43)


def test_a_box_may_be_turned_in_the_leaf(tmp_path: Path) -> None:
    old = '<origin xyz="0.6 -0.02 0.8" rpy="0 0 0"/>\n      <geometry><box size="1.2 0.04 1.6"/></geometry>\n    </collision>'
    new = old.replace('rpy="0 0 0"', 'rpy="0 1.5707963267948966 0"').replace("1.2 0.04 1.6", "1.6 0.04 1.2")
    door = Door(write_edited(tmp_path / "door.urdf", DOOR, (old, new)))
    np.testing.assert_allclose([door.width, door.height, door.thickness], [1.2, 1.6, 0.04], atol=1e-12)


def test_a_face_before_the_hinge_axis_is_told(tmp_path: Path) -> None:
    old = '<collision name="leaf">\n      <origin xyz="0.6 -0.02 0.8"'
    door = Door(write_edited(tmp_path / "door.urdf", DOOR, (old, old.replace("-0.02", "0.0"))))
    assert door.surface_offset == pytest.approx(0.02)


@pytest.mark.parametrize("angle", [0.0, 0.7, math.pi / 2, -1.0])
def test_leaf_and_contact_point_turn_about_the_hinge(angle: float) -> None:
    door = Door(DOOR)
    placement = door.link_placements(angle)["leaf"]
    np.testing.assert_allclose(placement[:3, 0], leaf_direction(angle), atol=1e-15)
    np.testing.assert_allclose(
        placement @ [0.7, 0.0, 0.8, 1.0], [*door.contact_point(angle, 0.7, 0.8), 1.0], atol=1e-15
    )
    np.testing.assert_allclose(-placement[:3, 1], door_normal(angle), atol=1e-15)


def test_the_closed_door_stands_along_y() -> None:
    np.testing.assert_allclose(Door(DOOR).contact_point(math.pi / 2, 0.7, 0.8), [0.0, 0.7, 1.2], atol=1e-15)
    np.testing.assert_allclose(door_normal(math.pi / 2), [1.0, 0.0, 0.0], atol=1e-15)


def test_torques_come_from_the_urdf_unless_the_scenario_says_otherwise(tmp_path: Path) -> None:
    path = write_door(tmp_path / "door.urdf", damping=0.3, friction=0.7)
    assert (Door(path).damping, Door(path).friction) == (0.3, 0.7)
    told = Door(path, DoorSection(damping=0.0, friction=0.2))
    assert (told.damping, told.friction) == (0.0, 0.2)


def test_torques_may_be_left_out_of_the_urdf(tmp_path: Path) -> None:
    door = Door(write_edited(tmp_path / "door.urdf", DOOR, ('<dynamics damping="0.0" friction="0.0"/>', "")))
    assert (door.damping, door.friction) == (0.0, 0.0)


def test_hinge_torque_adds_damping_friction_and_spring() -> None:
    door = Door(DOOR, DoorSection(damping=0.4, friction=0.6, friction_rate=0.05, stiffness=2.0, rest_angle=1.0))
    assert door.hinge_torque(1.0, 0.0) == 0.0
    assert door.hinge_torque(1.3, 0.0) == pytest.approx(0.6)
    assert door.hinge_torque(1.0, 10.0) == pytest.approx(4.6)
    assert door.hinge_torque(1.0, -10.0) == pytest.approx(-4.6)
    assert door.hinge_torque(1.0, 0.05) == pytest.approx(0.4 * 0.05 + 0.6 * math.tanh(1.0))
