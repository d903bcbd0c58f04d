"""Doors of either hand, anywhere in the world, closed at any value of their joint, with a face before the axis."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from urdf_variants import DOOR, write_door, write_edited, write_mirrored, write_moved

from doorman.exceptions import UrdfError
from doorman.kinematics.doors.door import Door
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.scenario import DoorSection

Array = NDArray[np.float64]

MIRROR = np.diag([1.0, -1.0, 1.0])
SIZES = (
    "mass",
    "inertia",
    "width",
    "height",
    "thickness",
    "surface_offset",
    "frame_depth",
    "lower_limit",
    "upper_limit",
)
ANGLES = (math.pi / 2, 0.9, 0.0, -0.4)


def same_sizes(one: Door, other: Door) -> None:
    for name in SIZES:
        assert getattr(one, name) == pytest.approx(getattr(other, name), abs=1e-9), name


def is_image_of(one: Door, other: Door, change: Array, position: Array) -> None:
    """Whether a door is another one's image at all its angles: the points of its leaf."""
    for angle in ANGLES:
        there = position + change @ other.contact_point(angle, 0.7, 0.8)
        np.testing.assert_allclose(one.contact_point(angle, 0.7, 0.8), there, atol=1e-9)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("yaw", [0.5, math.pi / 2, -2.6])
def test_a_door_may_stand_anywhere(mirrored: bool, yaw: float, tmp_path: Path) -> None:
    source = write_mirrored(tmp_path / "left.urdf", DOOR) if mirrored else DOOR
    moved = Door(write_moved(tmp_path / "moved.urdf", source, (3.0, -2.0, 0.5), yaw))
    assert moved.hand == (-1.0 if mirrored else 1.0)
    same_sizes(moved, Door(DOOR))
    change = rotation_body_to_world([0.0, 0.0, yaw]) @ (MIRROR if mirrored else np.eye(3))
    is_image_of(moved, Door(DOOR), change, np.array([3.0, -2.0, 0.5]))


@pytest.mark.parametrize("turn", [-math.pi / 2, 0.3, 2.0])
@pytest.mark.parametrize("axis", [1.0, -1.0])
def test_a_joint_may_be_closed_at_any_value(turn: float, axis: float, tmp_path: Path) -> None:
    """The joint's origin is turned, so that the same door has another zero, or its axis points down."""
    first, second = axis * (-1.5 - turn), axis * (1.5708 - turn)
    path = write_edited(
        tmp_path / "door.urdf",
        DOOR,
        ('<origin xyz="0 0 0.4" rpy="0 0 0"/>', f'<origin xyz="0 0 0.4" rpy="0 0 {turn}"/>'),
        ('<axis xyz="0 0 1"/>', f'<axis xyz="0 0 {axis}"/>'),
        ('lower="-1.5" upper="1.5708"', f'lower="{min(first, second)}" upper="{max(first, second)}"'),
    )
    door, other = Door(DOOR), Door(path)
    assert other.closed == pytest.approx(axis * (math.pi / 2 - turn), abs=1e-5)
    assert other.angle_of_joint(other.joint_value(0.3)) == pytest.approx(0.3, abs=1e-12)
    for angle in ANGLES:
        one, there = (each.link_placements(angle)["leaf"] for each in (door, other))
        np.testing.assert_allclose(there, one, atol=1e-4)  # π/2 is rounded in the URDF
    assert other.joint_rate(-0.2) == pytest.approx((other.joint_value(0.28) - other.joint_value(0.3)) / 0.1, abs=1e-9)


def test_a_mirrored_door_can_be_given_another_leaf(tmp_path: Path) -> None:
    left = write_mirrored(tmp_path / "left.urdf", DOOR)
    wide = write_mirrored(tmp_path / "wide.urdf", write_door(tmp_path / "right.urdf", width=1.35, mass=14.0))
    variant, written = Door(left, DoorSection(width=1.35, mass=14.0)), Door(wide)
    same_sizes(variant, written)
    np.testing.assert_allclose(
        variant.model.inertias[1].toDynamicParameters(), written.model.inertias[1].toDynamicParameters(), atol=1e-7
    )


def test_a_leaf_below_the_joints_origin_is_read_from_its_lower_edge(tmp_path: Path) -> None:
    path = write_edited(
        tmp_path / "door.urdf", DOOR,
        ('<origin xyz="0 0 0.4" rpy="0 0 0"/>', f'<origin xyz="0 0 2.0" rpy="{math.pi} 0 0"/>'),
        ('<axis xyz="0 0 1"/>', '<axis xyz="0 0 -1"/>'),
    )  # fmt: skip
    door, plain = Door(path), Door(DOOR)
    np.testing.assert_allclose(door.hinge_position, plain.hinge_position, atol=1e-12)
    for angle in ANGLES:
        np.testing.assert_allclose(door.leaf_direction(angle), plain.leaf_direction(angle), atol=1e-9)
    assert door.surface_offset == pytest.approx(0.04), "the leaf's face is its other one now"


def test_a_jamb_at_an_unlikely_value_asks_for_the_closed_one(tmp_path: Path) -> None:
    path = write_edited(
        tmp_path / "door.urdf", DOOR, ('<origin xyz="0 0 0.4" rpy="0 0 0"/>', '<origin xyz="0 0 0.4" rpy="0 0 0.5"/>')
    )
    with pytest.raises(UrdfError) as caught:
        Door(path)
    assert caught.value.field == "joint hinge" and "door.closed" in str(caught.value.allowed)
    np.testing.assert_allclose(Door(path, DoorSection(closed=math.pi / 2 - 0.5)).along, [0.0, 1.0, 0.0], atol=1e-9)


@pytest.mark.parametrize(("lean", "vertical"), [(1e-6, True), (math.radians(0.05), False)])
def test_a_hinge_counts_as_vertical_where_rounding_leans_it(lean: float, vertical: bool, tmp_path: Path) -> None:
    path = write_edited(
        tmp_path / "door.urdf", DOOR,
        ('<origin xyz="0 0 0.4" rpy="0 0 0"/>', f'<origin xyz="0 0 0.4" rpy="{lean} 0 0"/>'),
    )  # fmt: skip
    door, plain = Door(path), Door(DOOR)
    np.testing.assert_allclose(door.axes, plain.axes, atol=2e-3)
    np.testing.assert_allclose(door.axes @ door.axes.T, np.eye(3), atol=1e-8)
    assert door.vertical is vertical


def test_a_joint_may_turn_about_another_axis_of_its_frame(tmp_path: Path) -> None:
    half = math.pi / 2
    carrier = (
        f'<link name="carrier"/><joint name="hangs" type="fixed"><origin xyz="0 0 0" rpy="{half} 0 0"/>'
        '<parent link="carrier"/><child link="leaf"/></joint></robot>'
    )
    path = write_edited(
        tmp_path / "door.urdf", DOOR,
        ('<origin xyz="0 0 0.4" rpy="0 0 0"/>', f'<origin xyz="0 0 0.4" rpy="{-half} 0 0"/>'),
        ('<axis xyz="0 0 1"/>', '<axis xyz="0 -1 0"/>'), ('<child link="leaf"/>', '<child link="carrier"/>'),
        ("</robot>", carrier),
    )  # fmt: skip
    door, plain = Door(path), Door(DOOR)
    same_sizes(door, plain)
    is_image_of(door, plain, np.eye(3), np.zeros(3))
