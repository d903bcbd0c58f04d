"""Frames that are one mesh: their convex hull closes the doorway, and the check says so and which boxes leave it open."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from made_meshes import Box, stl_of_boxes
from urdf_variants import write_door, write_moved

from doorman.feasibility.inputs.hollow import hollow_findings
from doorman.feasibility.inputs.setup import setup_findings
from doorman.feasibility.report import Finding, Severity
from doorman.model import Model
from doorman.scenario import Scenario

AROUND = ("jamb_hinge", "jamb_latch", "lintel", "sill", "wall_hinge", "wall_latch", "wall_above")


def boxes_of(collisions: Sequence[ElementTree.Element]) -> list[Box]:
    found = []
    for one in collisions:
        center, size = one.find("origin").get("xyz"), one.find("geometry/box").get("size")
        found.append((np.array(center.split(), dtype=float), np.array(size.split(), dtype=float)))
    return found


def with_meshes(source: Path, *meshes: Sequence[str], extra: Sequence[Box] = ()) -> tuple[Path, list[Box]]:
    """A door whose frame's boxes of some names are meshes, one of all names of each; and those boxes."""
    tree = ElementTree.parse(source)
    frame = next(link for link in tree.getroot().findall("link") if link.get("name") == "frame")
    known = {one.get("name"): one for one in frame.findall("collision")}
    replaced: list[Box] = []
    for number, names in enumerate(meshes):
        boxes = [*boxes_of([known[name] for name in names]), *extra]
        (source.parent / f"frame_{number}.stl").write_bytes(stl_of_boxes(*boxes))
        shape = ElementTree.SubElement(frame, "collision", name=f"mesh_{number}")
        ElementTree.SubElement(ElementTree.SubElement(shape, "geometry"), "mesh", filename=f"frame_{number}.stl")
        replaced += boxes
    for name in {name for names in meshes for name in names}:
        frame.remove(known[name])
    path = source.with_name("meshes.urdf")
    tree.write(path)
    return path, replaced


def model_of(door: Path, **keys: object) -> Model:
    values = {"door.urdf": str(door), "door.closed": 0.5 * np.pi, **{k.replace("__", "."): v for k, v in keys.items()}}
    return Model(Scenario.load("paper", values))


def advised(finding: Finding) -> list[Box]:
    """Boxes that the advice writes."""
    box = r'<collision><origin xyz="([^"]*)"/><geometry><box size="([^"]*)"/></geometry></collision>'
    found = re.findall(box, finding.advice)
    return [(np.array(center.split(), dtype=float), np.array(size.split(), dtype=float)) for center, size in found]


def inside(boxes: Sequence[Box], points: np.ndarray, rim: float = 0.0) -> np.ndarray:
    return np.any([(np.abs(points - center) < 0.5 * size + rim).all(axis=1) for center, size in boxes], axis=0)


def original(folder: Path) -> Path:
    return write_door(folder / "door.urdf")


def moved(folder: Path) -> Path:
    return write_moved(folder / "moved.urdf", original(folder), (1.0, -2.0, 0.3), 0.7)


@pytest.mark.parametrize("door", [original, moved])
@pytest.mark.parametrize("names", [AROUND, AROUND[:3], AROUND[:4]], ids=["wall", "posts and lintel", "and sill"])
def test_a_frame_of_one_mesh_closes_its_doorway(
    door: Callable[[Path], Path], names: Sequence[str], tmp_path: Path
) -> None:
    path, boxes = with_meshes(door(tmp_path), names)
    model = model_of(path)
    (finding,) = (one for one in setup_findings(model) if one.name.startswith("hull of"))
    assert finding.severity is Severity.ERROR and finding.value > 0.9
    assert "frame_0.stl" in finding.message and "'frame'" in finding.message
    draws = np.random.default_rng(5).uniform([-0.2, -1.0, -0.1], [0.1, 2.2, 2.6], (20_000, 3))
    written = advised(finding)
    assert len(written) == (4 if "sill" in names else 3)
    assert not (inside(boxes, draws) & ~inside(written, draws, rim=2e-3)).any()
    free = (np.abs(draws[:, 1] - 0.6) < 0.595) & (np.abs(draws[:, 2] - 1.2) < 0.795)
    assert free.sum() > 1000 and not inside(written, draws[free]).any()


def test_the_boxes_of_the_advice_leave_the_doorway_open(tmp_path: Path) -> None:
    path, _ = with_meshes(original(tmp_path), AROUND)
    (finding,) = hollow_findings(model_of(path))
    shapes = "".join(re.findall(r"<collision>.*?</collision>", finding.advice))
    text = re.sub(
        r'<collision name="mesh_0">.*?</collision>', shapes, path.read_text(encoding="utf-8"), flags=re.DOTALL
    )
    path.write_text(text, encoding="utf-8")
    model = model_of(path)
    assert hollow_findings(model) == []
    assert model.door.frame_depth == pytest.approx(0.12, abs=2e-3)


def test_meshes_that_are_convex_leave_it_open(tmp_path: Path) -> None:
    path, _ = with_meshes(original(tmp_path), *([name] for name in AROUND))
    findings = hollow_findings(model_of(path))
    assert len(findings) == len(AROUND) and all(one.severity is Severity.OK for one in findings)


def test_a_vehicle_that_pulls_stays_before_the_hull(tmp_path: Path) -> None:
    path, _ = with_meshes(original(tmp_path), AROUND)
    (finding,) = hollow_findings(model_of(path, contact__side="pull", goal__door_angle=None, goal__opening=1.0))
    assert finding.severity is Severity.OK


def test_a_leaf_that_stands_back_in_its_mesh_is_behind_the_hull(tmp_path: Path) -> None:
    """Posts and lintel that reach 10 cm before the face of a leaf that is pulled."""
    path, _ = with_meshes(
        original(tmp_path), AROUND[:3],
        extra=[(np.array([0.07, y, 1.2]), np.array([0.14, 0.08, 1.6])) for y in (-0.04, 1.24)],
    )  # fmt: skip
    (finding,) = hollow_findings(model_of(path, contact__side="pull", goal__door_angle=None, goal__opening=1.0))
    assert finding.severity is Severity.ERROR
