"""URDFs and meshes that would crash a library, or take for ever: refused before one sees them."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from made_meshes import TETRAHEDRON, stl
from urdf_variants import DOOR, VEHICLE, write_edited

from doorman.exceptions import UrdfError
from doorman.kinematics.doors.door import Door
from doorman.kinematics.urdf import document as urdf_document
from doorman.kinematics.urdf import mesh_hull
from doorman.kinematics.urdf.robot import load_pinocchio
from doorman.kinematics.vehicles.vehicle import Vehicle

END = "</robot>"
JAMB = '<box size="0.12 0.08 2.08"/>'
LARGEST_TIME = 5.0
"""To refuse a file, on a busy computer [s]."""


def refused(path: Path, words: str, field: str, reader=Door) -> UrdfError:
    began = time.perf_counter()
    with pytest.raises(UrdfError, match=words) as caught:
        reader(path)
    assert time.perf_counter() - began < LARGEST_TIME
    assert caught.value.file == str(path)
    assert field in str(caught.value.field)
    assert caught.value.given is not None and caught.value.allowed
    return caught.value


def door(tmp_path: Path, old: str, new: str) -> Path:
    return write_edited(tmp_path / "door.urdf", DOOR, (old, new))


def chain(count: int) -> str:
    names = ["leaf", *(f"c{k}" for k in range(count))]
    joints = (
        f'<link name="{child}"/><joint name="j_{child}" type="fixed"><parent link="{parent}"/><child link="{child}"/></joint>'
        for parent, child in zip(names, names[1:], strict=False)
    )
    return "".join(joints) + END


@pytest.mark.parametrize(
    ("old", "new", "field"),
    [
        (JAMB, '<box size="0.12 1001 2.08"/>', "geometry/box@size"),
        (JAMB, '<sphere radius="1e4"/>', "geometry/sphere@radius"),
        (JAMB, '<cylinder radius="0.1" length="2000"/>', "geometry/cylinder@length"),
        ('xyz="0 0 0.4"', 'xyz="0 0 -1200"', "joint[hinge]/origin@xyz"),
        ('<mass value="11"/>', '<mass value="2e5"/>', "inertial/mass@value"),
        ('damping="0.0"', 'damping="1e7"', "dynamics@damping"),
    ],
)
def test_sizes_beyond_a_kilometre_and_masses_beyond_all_doors_are_refused(tmp_path, old, new, field):
    refused(door(tmp_path, old, new), "too large", field)


def test_a_kilometre_is_read(tmp_path):
    assert Door(door(tmp_path, JAMB, '<box size="1000 0.08 2.08"/>')).width == pytest.approx(1.2)


@pytest.mark.parametrize("reader", [Door, load_pinocchio])
@pytest.mark.parametrize("count", [999, 20_000])
def test_too_many_links_are_refused(tmp_path, reader, count):
    refused(door(tmp_path, END, chain(count)), "too many links", "/robot/link", reader)


def test_a_thousand_links_are_read(tmp_path):
    assert load_pinocchio(door(tmp_path, END, chain(998))).nframes > 1900


@pytest.mark.parametrize("depth", [99, 100_000])
def test_elements_nested_too_deep_are_refused(tmp_path, depth):
    nest = f"<gazebo>{'<a>' * depth}{'</a>' * depth}</gazebo>{END}"
    refused(door(tmp_path, END, nest), "nested too deep", "/robot/gazebo")
    shallow = f"<gazebo>{'<a>' * 98}{'</a>' * 98}</gazebo>{END}"
    assert Door(door(tmp_path, END, shallow)).mass == 11.0


def test_too_many_elements_are_refused(tmp_path):
    refused(
        door(tmp_path, END, "<material/>" * urdf_document.MOST_ELEMENTS + END), "too many elements", "/robot/material"
    )


def test_a_huge_file_is_refused_by_its_size(tmp_path):
    path = door(tmp_path, END, END)
    with path.open("ab") as file:
        file.truncate(50 * urdf_document.LARGEST_FILE)  # a hole: it takes no room
    refused(path, "too large a file", "file")


@pytest.mark.parametrize(
    "entity", ['<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;">', '<!ENTITY a SYSTEM "/etc/hostname">', ""]
)
def test_entities_are_refused(tmp_path, entity):
    path = tmp_path / "door.urdf"
    text = DOOR.read_text(encoding="utf-8").replace("<robot", f"<!DOCTYPE robot [{entity}]>\n<robot", 1)
    path.write_text(text, encoding="utf-8")
    refused(path, "document type", "XML")


def test_an_axis_that_rounding_loses_is_refused(tmp_path):
    refused(
        door(tmp_path, '<axis xyz="0 0 1"/>', '<axis xyz="0 0 1e-200"/>'), "without direction", "joint[hinge]/axis@xyz"
    )


NAN = [[(0, 0, 0), (float("nan"), 0, 0), (0, 1, 0)]]
FAR = [[(0, 0, 0), (2000, 0, 0), (0, 1, 0)]]
MESHES = [
    ("a.stl", stl(NAN), "1 1 1", "within 1000 m"),
    ("a.stl", stl(FAR), "1 1 1", "within 1000 m"),
    ("a.stl", stl(TETRAHEDRON), "1 5000 1", "within 1000 m"),
    ("a.stl", stl(TETRAHEDRON)[:150], "1 1 1", "STL"),
    ("a.stl", stl([]), "1 1 1", "STL"),
    ("a.stl", stl([[(0, 0, 0)] * 3]), "1 1 1", ""),
    ("a.STL", b"solid a\nfacet\nvertex 0 0 inf\nendsolid", "1 1 1", ""),
    ("a.stl", b"solid a\nvertex 0 zero 0\n", "1 1 1", ""),
    ("a.obj", b"v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", "1 1 1", "within 1000 m"),
    ("a.obj", b"v 0 0\n", "1 1 1", ""),
    ("a.obj", b"v 0 0 0\nf 9 9 9\n", "1 1 1", ""),
    ("a.obj", b"", "1 1 1", "0 bytes"),
    ("a.dae", b"", "1 1 1", "0 bytes"),
]


@pytest.mark.parametrize(("name", "content", "scale", "why"), MESHES)
def test_a_broken_mesh_is_refused_with_its_name_and_link(tmp_path, name, content, scale, why):
    (tmp_path / name).write_bytes(content)
    mesh = f'<mesh filename="{name}" scale="{scale}"/>'
    text = DOOR.read_text(encoding="utf-8")
    at = text.rindex(JAMB)  # of a collision shape
    path = tmp_path / "door.urdf"
    path.write_text(text[:at] + mesh + text[at + len(JAMB) :], encoding="utf-8")
    given = str(refused(path, "cannot be read", "link frame/collision").given)
    assert given.startswith(f"{name}: ") and why in given


def test_large_meshes_are_refused(tmp_path, monkeypatch):
    (tmp_path / "a.stl").write_bytes(stl(TETRAHEDRON))
    path = write_edited(
        tmp_path / "v.urdf", VEHICLE, ('<cylinder radius="0.40" length="0.0004"/>', '<mesh filename="a.stl"/>')
    )
    assert Vehicle(path).radius == pytest.approx(1.0)
    monkeypatch.setattr(mesh_hull, "MOST_VERTICES", 3)
    refused(path, "cannot be read.*4 vertices", "vehicle.radius", Vehicle)
    with (tmp_path / "a.stl").open("ab") as file:
        file.truncate(mesh_hull.LARGEST_SHAPE + 1)
    refused(path, "cannot be read.*bytes", "vehicle.radius", Vehicle)
