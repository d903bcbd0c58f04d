"""Doors of another width and mass, against doors that were written with these from the start."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from urdf_variants import DOOR, write_door, write_edited

from doorman.collision.shapes import read_shapes
from doorman.exceptions import UrdfError
from doorman.kinematics.doors.door import Door
from doorman.kinematics.doors.variants import variant as door_variant
from doorman.kinematics.doors.variants.variant import write_door_variant
from doorman.kinematics.urdf.robot import load_pinocchio
from doorman.model import Model
from doorman.scenario import DoorSection, Scenario
from doorman.visualization.scene.shapes import visual_shapes

ALONG = (np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
"""The shipped leaf, in its link and, closed, in the world."""


@pytest.mark.parametrize(("width", "mass"), [(1.1, 6.0), (1.4, 20.0), (1.35, 11.0)])
def test_a_variant_is_the_door_written_with_that_width_and_mass(width, mass, tmp_path: Path) -> None:
    variant = Door(DOOR, DoorSection(width=width, mass=mass))
    written = Door(write_door(tmp_path / "door.urdf", width=width, mass=mass))
    assert variant.inertia == pytest.approx(mass * width**2 / 3.0, rel=1e-8)
    for name in ("mass", "inertia", "width", "height", "thickness", "surface_offset"):
        assert getattr(variant, name) == pytest.approx(getattr(written, name), abs=1e-7), name
    np.testing.assert_allclose(
        variant.model.inertias[1].toDynamicParameters(), written.model.inertias[1].toDynamicParameters(), atol=1e-7
    )
    floorless = [[one for one in read_shapes(door.urdf) if "floor" not in one.name] for door in (variant, written)]
    for one, other in zip(*floorless, strict=True):
        np.testing.assert_allclose(one.placement, other.placement, atol=1e-9, err_msg=one.name)
        np.testing.assert_allclose(one.half_extents, other.half_extents, atol=1e-9, err_msg=one.name)


def test_what_is_only_seen_stays_at_its_edge() -> None:
    plain = {shape.kind: shape for shape in visual_shapes(DOOR) if shape.link == "leaf"}
    wide = {
        shape.kind: shape for shape in visual_shapes(Door(DOOR, DoorSection(width=1.4)).urdf) if shape.link == "leaf"
    }
    assert wide["cylinder"].placement[0, 3] - plain["cylinder"].placement[0, 3] == pytest.approx(0.2)
    assert wide["cylinder"].size == plain["cylinder"].size
    panels = [
        shape
        for shape in visual_shapes(Door(DOOR, DoorSection(width=1.4)).urdf)
        if shape.size[0] == pytest.approx(1.06)
    ]
    assert len(panels) == 2 and all(panel.placement[0, 3] == pytest.approx(0.7) for panel in panels)


def test_a_turned_inertial_is_spread_along_the_leaf(tmp_path: Path) -> None:
    turned = write_edited(
        tmp_path / "door.urdf", DOOR, ('"0.6 0 0.8" rpy="0 0 0"', '"0.6 0 0.8" rpy="0 1.5707963267948966 0"'),
        ('ixx="2.34666667"', 'ixx="1.32"'), ('izz="1.32"', 'izz="2.34666667"'),
    )  # fmt: skip
    wide = DoorSection(width=1.4)
    np.testing.assert_allclose(
        Door(turned, wide).model.inertias[1].toDynamicParameters(),
        Door(DOOR, wide).model.inertias[1].toDynamicParameters(), atol=1e-9,
    )  # fmt: skip


def test_a_scenario_takes_both_and_keeps_the_shipped_file() -> None:
    scenario = Scenario.load("push", {"door.width": 1.31, "door.mass": 9.0})
    model = Model(scenario)
    assert scenario.door_urdf.name == "hinged_door.urdf"
    assert model.door.width == pytest.approx(1.31) and model.door.mass == pytest.approx(9.0)
    assert model.reduced.numbers.one("door.width") == pytest.approx(1.31)
    assert Model(scenario).door.urdf == model.door.urdf


def test_a_door_of_more_links_keeps_its_leaf(tmp_path: Path) -> None:
    knob = (
        '<link name="knob"/><joint name="knob" type="fixed"><parent link="leaf"/><child link="knob"/></joint></robot>'
    )
    path = write_edited(tmp_path / "door.urdf", DOOR, ("</robot>", knob))
    assert Door(path).mass == pytest.approx(11.0)
    with pytest.raises(UrdfError) as caught:
        Door(path, DoorSection(width=1.3))
    assert caught.value.field == "door.width, door.mass" and "knob" in str(caught.value.given)


def test_a_door_of_meshes_keeps_its_leaf(tmp_path: Path) -> None:
    mesh = '<cylinder radius="0.009" length="0.12"/>', '<mesh filename="handle.stl"/>'
    path = write_edited(tmp_path / "door.urdf", DOOR, mesh)
    with pytest.raises(UrdfError, match="meshes"):
        Door(path, DoorSection(mass=9.0))


def test_threads_that_make_the_same_door_do_not_meet_a_half_written_file(tmp_path, monkeypatch):
    monkeypatch.setattr(door_variant, "cache_directory", lambda: tmp_path)
    paths: list[Path] = []

    def make(width: float) -> None:
        path = write_door_variant(DOOR, "leaf", np.zeros(3), *ALONG, 1.2, width, None)
        paths.append(path)
        load_pinocchio(path)

    for number in range(15):
        with ThreadPoolExecutor(6) as pool:
            list(pool.map(make, [1.1 + 1e-3 * number] * 6))  # raises what a thread raised
    assert len(set(paths)) == 15
    assert not list(tmp_path.rglob("*.tmp"))


@pytest.mark.parametrize("damage", [b"", b"<robot"])
def test_a_damaged_variant_is_written_anew(damage, tmp_path, monkeypatch):
    monkeypatch.setattr(door_variant, "cache_directory", lambda: tmp_path)
    path = write_door_variant(DOOR, "leaf", np.zeros(3), *ALONG, 1.2, 1.1, None)
    whole = path.read_bytes()
    path.write_bytes(damage)
    assert write_door_variant(DOOR, "leaf", np.zeros(3), *ALONG, 1.2, 1.1, None) == path
    assert path.read_bytes() == whole


def test_a_variant_goes_elsewhere_where_the_cache_cannot_be_written(tmp_path, monkeypatch):
    (tmp_path / "doors").write_text("no directory")
    monkeypatch.setattr(door_variant, "cache_directory", lambda: tmp_path)
    path = write_door_variant(DOOR, "leaf", np.zeros(3), *ALONG, 1.2, 1.1, None)
    assert not path.is_relative_to(tmp_path)
    load_pinocchio(path)
