"""Leaves of many parts, as other authors write them: frame and panel, bars, handles, meshes, and where they are closed."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from doorman import Scenario
from doorman.exceptions import ScenarioError, UrdfError
from doorman.kinematics.doors.door import Door
from doorman.kinematics.doors.reading import read_door
from doorman.scenario import DoorSection

JAMBS = [((-0.06, 0.0, 1.0), (0.1, 0.12, 2.1)), ((0.96, 0.0, 1.0), (0.1, 0.12, 2.1))]
STILES = [((0.05, 0.0, 1.0), (0.1, 0.04, 2.0)), ((0.85, 0.0, 1.0), (0.1, 0.04, 2.0))]
PANEL = [((0.45, 0.0, 1.0), (0.7, 0.016, 1.9))]
RAILS = [((0.45, 0.0, height), (0.7, 0.04, 0.1)) for height in (0.05, 1.95)]
BARS = [((0.05 + 0.1 * k, 0.0, 1.0), (0.03, 0.03, 1.9)) for k in range(9)]


def box(place: tuple[float, ...], size: tuple[float, ...]) -> str:
    at, edges = (" ".join(map(str, numbers)) for numbers in (place, size))
    return f'<collision><origin xyz="{at}"/><geometry><box size="{edges}"/></geometry></collision>'


def write(
    path: Path, leaf: str, frame: str = "".join(box(*jamb) for jamb in JAMBS), limits: tuple[float, float] = (0.0, 1.7),
    before: str = "", root: str = "base", more: str = "",
) -> Path:  # fmt: skip
    """A door along x of its frame at joint value 0, which opens towards y."""
    path.write_text(
        f'<robot name="d">{before}<link name="{root}">{frame}</link><joint name="hinge" type="revolute"><parent link="{root}"/>'
        f'<child link="leaf"/><axis xyz="0 0 1"/><limit lower="{limits[0]}" upper="{limits[1]}"/></joint><link name="leaf">'
        '<inertial><origin xyz="0.45 0 1"/><mass value="12"/>'
        f'<inertia ixx="4" ixy="0" ixz="0" iyy="4.8" iyz="0" izz="0.8"/></inertial>{leaf}</link>{more}</robot>',
        encoding="utf-8",
    )
    return path


def boxes(*parts: list[tuple[tuple[float, ...], tuple[float, ...]]]) -> str:
    return "".join(box(*part) for group in parts for part in group)


@pytest.mark.parametrize(
    ("leaf", "sizes"),
    [
        (boxes(STILES, RAILS, PANEL), (0.9, 2.0, 0.04)),
        (boxes(BARS, RAILS), (0.865, 2.0, 0.04)),
        (boxes(STILES, RAILS, PANEL, [((0.8, -0.05, 1.05), (0.12, 0.06, 0.03))]), (0.9, 2.0, 0.04)),
    ],
    ids=["frame and panel", "bars", "with a handle"],
)
def test_a_leaf_is_the_hull_of_its_parts_without_its_handle(
    tmp_path: Path, leaf: str, sizes: tuple[float, float, float]
) -> None:
    door = Door(write(tmp_path / "d.urdf", leaf))
    np.testing.assert_allclose((door.width, door.height, door.thickness), sizes, atol=1e-9)
    assert (door.closed, door.closed_is_guessed) == (0.0, False)
    np.testing.assert_allclose(door.hinge_position, [0.0, 0.0, 0.0], atol=1e-9)


def test_a_panel_behind_its_frame_is_touched_where_it_is(tmp_path: Path) -> None:
    urdf = write(tmp_path / "d.urdf", boxes(STILES, RAILS, PANEL))
    task = {"door": {"urdf": str(urdf)}, "contact": {"height": 1.0, "distance_from_hinge": 0.5}}
    assert read_door(Scenario(**task)).contact_offset == pytest.approx(0.008)
    assert read_door(Scenario(**task)).surface_offset == pytest.approx(0.02)
    task["contact"]["distance_from_hinge"] = 0.86
    assert read_door(Scenario(**task)).contact_offset == pytest.approx(0.02), "on a stile"


def test_a_leaf_of_a_mesh_alone_is_read(tmp_path: Path) -> None:
    corners = np.array(np.meshgrid([0.0, 0.9], [-0.02, 0.02], [0.0, 2.0])).reshape(3, -1).T
    faces = [(0, 1, 2), (1, 3, 2), (4, 6, 5), (5, 6, 7), (0, 2, 4), (2, 6, 4), (1, 5, 3), (3, 5, 7), (0, 4, 1), (1, 4, 5),
             (2, 3, 6), (3, 7, 6)]  # fmt: skip
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    (tmp_path / "leaf.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    door = Door(write(tmp_path / "d.urdf", '<collision><geometry><mesh filename="leaf.obj"/></geometry></collision>'))
    np.testing.assert_allclose((door.width, door.height, door.thickness), (0.9, 2.0, 0.04), atol=1e-6)


@pytest.mark.parametrize("limits", [(0.0, 1.92), (-1.92, 0.0), (0.0, math.pi), (-0.01, 1.8)])
def test_without_a_frame_closed_is_guessed_at_the_end_at_zero(tmp_path: Path, limits: tuple[float, float]) -> None:
    urdf = write(tmp_path / "d.urdf", boxes(PANEL), "", limits)
    door = Door(urdf)
    assert door.closed_is_guessed and not door.framed
    assert door.closed == min(limits, key=abs)
    told = Door(urdf, DoorSection(closed=limits[1]))
    assert told.closed == limits[1] and not told.closed_is_guessed


@pytest.mark.parametrize("side", ["push", "pull"])
def test_a_contact_may_be_a_link_or_a_point(tmp_path: Path, side: str) -> None:
    """The door opens towards y, where it is pulled."""
    outward = 1.0 if side == "pull" else -1.0
    more = (
        '<link name="handle">' + box((0.8, 0.05 * outward, 1.05), (0.12, 0.06, 0.03)) + "</link>"
        '<joint name="f" type="fixed"><parent link="leaf"/><child link="handle"/></joint>'
    )
    urdf = write(tmp_path / "d.urdf", boxes(STILES, RAILS, PANEL), more=more)
    door = read_door(Scenario(door={"urdf": str(urdf)}, contact={"link": "handle"}))
    assert door.side == side
    np.testing.assert_allclose(door.handle, (0.8, 1.05, 0.08), atol=1e-9)
    at = {"point": [0.8, 0.08 * outward, 1.05], "normal": [0.0, 3.0 * outward, 0.0]}
    same = read_door(Scenario(door={"urdf": str(urdf)}, contact=at))
    assert same.side == side
    np.testing.assert_allclose(same.handle, door.handle, atol=1e-9)
    del at["normal"]
    np.testing.assert_allclose(
        read_door(Scenario(door={"urdf": str(urdf)}, contact={**at, "side": side})).handle, door.handle, atol=1e-9
    )


def test_a_contact_has_one_place(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="one of contact"):
        Scenario(contact={"link": "handle", "point": [0.8, 0.08, 1.05]})
    with pytest.raises(ScenarioError, match="beside contact.point"):
        Scenario(contact={"normal": [1.0, 0.0, 0.0]})
    urdf = write(tmp_path / "d.urdf", boxes(PANEL))
    with pytest.raises(UrdfError, match="does not move with the leaf"):
        read_door(Scenario(door={"urdf": str(urdf)}, contact={"link": "base"}))


def test_a_base_that_rolls_stands_at_zero(tmp_path: Path) -> None:
    before = (
        '<link name="floor"/><link name="cart"/>'
        '<joint name="x" type="prismatic"><parent link="floor"/><child link="cart"/><axis xyz="1 0 0"/></joint>'
        '<joint name="z" type="prismatic"><parent link="cart"/><child link="base"/><axis xyz="0 0 1"/>'
        '<limit lower="2" upper="-2" velocity="-1"/></joint>'
    )
    assert Door(write(tmp_path / "d.urdf", boxes(PANEL), before=before)).standing_joints == ("x", "z")
