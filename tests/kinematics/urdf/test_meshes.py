"""Meshes of a URDF: the file that the URDF names, for every library, from any working directory."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from made_meshes import stl_of_boxes
from urdf_variants import VEHICLE, write_edited

from doorman.collision.shapes import read_shapes
from doorman.exceptions import DoormanError, UrdfError
from doorman.kinematics.urdf.mesh_files import mesh_path
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.simulation.simulator import Simulator

DISC = '<cylinder radius="0.40" length="0.0004"/>'
HALF = 0.3, 0.4, 0.5, 0.6
"""Half edges of the boxes in the places where somebody may look for a mesh [m]; the first is the right one."""


def write_box(path: Path, half: float) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(stl_of_boxes((np.zeros(3), (2.0 * half, 2.0 * half, 0.02))))


@pytest.fixture
def vehicle_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Writes a vehicle whose disc is a mesh; other meshes of its name lie wherever else one might look."""
    folder, elsewhere = tmp_path / "share" / "uam" / "urdf", tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)

    def write(filename: str) -> Path:
        relative = filename.partition("://")[2] or filename
        places = [elsewhere / relative, folder.parent / relative, folder / Path(relative).name]
        if filename.startswith("package://"):
            places[1] = folder.parent.parent.parent / relative
        for place, half in zip(places, HALF[1:], strict=True):
            write_box(place, half)
        right = folder.parent.parent / relative if filename.startswith("package://") else folder / relative
        write_box(right, HALF[0])
        folder.mkdir(parents=True, exist_ok=True)
        text = VEHICLE.read_text(encoding="utf-8")
        assert text.count(DISC) == 1
        path = folder / "vehicle.urdf"
        path.write_text(text.replace(DISC, f'<mesh filename="{filename}"/>'), encoding="utf-8")
        return path

    return write


FILENAMES = ["meshes/disc.stl", "./meshes/disc.stl", "package://uam/meshes/disc.stl"]


@pytest.mark.parametrize("filename", FILENAMES)
def test_every_library_reads_the_mesh_that_the_urdf_names(vehicle_of, filename):
    path = vehicle_of(filename)
    vehicle = Vehicle(path)
    assert vehicle.radius == pytest.approx(np.hypot(HALF[0], HALF[0]), abs=1e-6)
    (disc,) = (shape for shape in read_shapes(path) if shape.half_extents[2] == pytest.approx(0.01))
    assert disc.half_extents[0] == pytest.approx(HALF[0])
    simulator = Simulator(Model(Scenario(vehicle={"urdf": str(path)})), 0.001)
    meshes = simulator.plant.engine_model
    assert np.ptp(meshes.mesh_vert[:, :2]) == pytest.approx(2 * HALF[0], abs=1e-6)


def test_absolute_files_are_read(vehicle_of, tmp_path):
    write_box(tmp_path / "far" / "disc.stl", 0.25)
    for filename in (f"file://{tmp_path}/far/disc.stl", f"{tmp_path}/far/disc.stl"):
        text = vehicle_of("meshes/disc.stl").read_text().replace("meshes/disc.stl", filename)
        path = tmp_path / "vehicle.urdf"
        path.write_text(text)
        assert Vehicle(path).radius == pytest.approx(np.hypot(0.25, 0.25), abs=1e-6)


@pytest.mark.parametrize("filename", ["meshes/disc.stl", "package://uam/meshes/disc.stl", "../meshes/disc.stl"])
def test_a_mesh_that_lies_elsewhere_is_not_read_instead(tmp_path, monkeypatch, filename):
    for place in ("elsewhere/meshes/disc.stl", "elsewhere/uam/meshes/disc.stl", "a/b/disc.stl", "meshes/disc.stl"):
        write_box(tmp_path / place, 0.3)
    monkeypatch.chdir(tmp_path / "elsewhere")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "elsewhere"))
    path = write_edited(tmp_path / "a" / "b" / "vehicle.urdf", VEHICLE, (DISC, f'<mesh filename="{filename}"/>'))
    for read in (Vehicle, read_shapes):
        with pytest.raises(UrdfError) as caught:
            read(path)
        assert "disc.stl" in str(caught.value) and str(path) in str(caught.value)


@pytest.mark.parametrize(
    "filename", ["http://example.com/disc.stl", "model://uam/disc.stl", "package:/a", "https://a/b.stl"]
)
def test_other_addresses_are_refused_with_the_fix(tmp_path, filename):
    path = write_edited(tmp_path / "vehicle.urdf", VEHICLE, (DISC, f'<mesh filename="{filename}"/>'))
    for read in (Vehicle, read_shapes, lambda path: Model(Scenario(vehicle={"urdf": str(path)}))):
        with pytest.raises(DoormanError) as caught:
            read(path)
        assert filename in str(caught.value)
        if "://" in filename:
            assert "package://NAME/path" in caught.value.allowed and "base_link" in caught.value.field


def test_visual_meshes_are_left_alone(tmp_path):
    visual = '<cylinder radius="0.085" length="0.036"/>'
    path = write_edited(tmp_path / "v.urdf", VEHICLE, (visual, '<mesh filename="model://nowhere/hull.dae"/>'))
    assert Simulator(Model(Scenario(vehicle={"urdf": str(path)})), 0.001).plant.engine_model.nmesh == 0
    assert mesh_path(path, "a/b.stl", "") == tmp_path / "a" / "b.stl"
