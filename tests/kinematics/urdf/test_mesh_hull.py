"""Convex hulls of meshes: exact for known bodies, the same for FCL, coal and MuJoCo, and errors that name the mesh."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import coal
import fcl
import numpy as np
import pytest
from urdf_variants import VEHICLE, robot_data_vehicle, write_edited

from doorman.collision.shapes import read_shapes
from doorman.exceptions import BackendError, UrdfError
from doorman.kinematics.urdf.elements import read_collisions
from doorman.kinematics.urdf.mesh_hull import bounding_box, convex_hull
from doorman.simulation.plant.hulls import read_spec

mujoco = pytest.importorskip("mujoco")

DISC = '<cylinder radius="0.40" length="0.0004"/>'


def obj(path: Path, vertices: np.ndarray) -> None:
    """Any points as an OBJ; its faces are of no account to a hull."""
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {k} {k + 1} {k + 2}" for k in range(1, len(vertices) - 1)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def with_mesh(tmp_path: Path, vertices: np.ndarray, scale: str = "1 1 1", name: str = "odd hull.obj") -> Path:
    obj(tmp_path / name, vertices)
    return write_edited(tmp_path / "v.urdf", VEHICLE, (DISC, f'<mesh filename="{name}" scale="{scale}"/>'))


def mesh_shape(path: Path):
    return next(shape for shape in read_collisions(path) if shape.kind == "mesh")


def volume(vertices: np.ndarray, triangles: np.ndarray) -> float:
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def test_hull_of_a_box_with_points_inside(tmp_path: Path, rng: np.random.Generator) -> None:
    corners = np.array(list(itertools.product((-0.3, 0.5), (-0.2, 0.2), (0.0, 0.1))))
    path = with_mesh(tmp_path, np.vstack([rng.uniform(0.01, 0.09, (40, 3)), corners]), "1 2 -1")
    hull = convex_hull(path, mesh_shape(path))
    assert sorted(map(tuple, hull.vertices.round(6))) == sorted(map(tuple, (corners * [1, 2, -1]).round(6)))
    assert volume(hull.vertices, hull.triangles) == pytest.approx(0.8 * 0.8 * 0.1, rel=1e-6)
    np.testing.assert_allclose(bounding_box(path, mesh_shape(path)), [[0.1, 0.0, -0.05], [0.8, 0.8, 0.1]], atol=1e-6)
    assert not hull.vertices.flags.writeable and not hull.triangles.flags.writeable


@pytest.mark.parametrize(
    ("vertices", "words"),
    [
        (np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]]), "no volume"),
        (np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1e-9]]), "no volume"),
        (np.array([[0, 0, 0], [1, 1, 1], [2, 2, 2], [3, 3, 3.0]]), "no volume"),
        (np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 4000.0]]), "within 1000 m"),
    ],
)
def test_what_has_no_hull_is_named_by_every_reader(tmp_path: Path, vertices: np.ndarray, words: str) -> None:
    path = with_mesh(tmp_path, vertices)
    for read in (lambda: read_shapes(path), lambda: read_spec(mujoco, path)):
        with pytest.raises((UrdfError, BackendError)) as caught:
            read()
        text = str(caught.value)
        assert "odd hull.obj" in text and "base_link" in text
        assert words in text


def scattered(rng: np.random.Generator) -> np.ndarray:
    directions = rng.normal(size=(60, 3))
    return 0.2 * directions / np.linalg.norm(directions, axis=1)[:, None] * rng.uniform(0.5, 1.0, (60, 1))


@pytest.mark.parametrize("kind", ["obj", "dae"])
def test_fcl_coal_and_mujoco_have_one_hull(tmp_path: Path, rng: np.random.Generator, kind: str) -> None:
    """Distance of a ball from the mesh in each engine."""
    path = (
        with_mesh(tmp_path, scattered(rng), "1 -1.5 0.7")
        if kind == "obj"
        else robot_data_vehicle("hextilt_flying_arm_5")[0]
    )
    written = mesh_shape(path)
    hull = convex_hull(path, written)
    shape = next(shape for shape in read_shapes(path) if shape.link == written.link)
    spec = read_spec(mujoco, path)
    spec.compiler.fusestatic = False
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    spec.compiler.boundmass = spec.compiler.boundinertia = 1e-6
    ball = spec.worldbody.add_body(name="ball", mocap=True)
    ball.add_geom(name="ball", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.05, 0, 0])
    engine = spec.compile()
    data = mujoco.MjData(engine)
    mujoco.mj_kinematics(engine, data)
    mesh = next(g for g in range(engine.ngeom) if engine.geom_type[g] == mujoco.mjtGeom.mjGEOM_MESH)
    mine = coal.StdVec_Vec3s()
    for vertex in hull.vertices:
        mine.append(vertex)
    convex = coal.Convex.convexHull(mine, True, "Qt")
    body = data.body(int(engine.geom_bodyid[mesh]))
    link = np.eye(4)
    link[:3, :3], link[:3, 3] = body.xmat.reshape(3, 3), body.xpos
    placed = link @ written.placement
    for place in rng.normal(size=(15, 3)):
        place *= 0.8 / math.sqrt(place @ place)
        data.mocap_pos[0] = place
        mujoco.mj_kinematics(engine, data)
        by_mujoco = mujoco.mj_geomDistance(engine, data, mesh, engine.geom("ball").id, 10.0, None)
        by_coal = coal.distance(
            convex, coal.Transform3s(placed[:3, :3], placed[:3, 3]), coal.Sphere(0.05),
            coal.Transform3s(np.eye(3), place), coal.DistanceRequest(), coal.DistanceResult(),
        )  # fmt: skip
        of_shape = link @ shape.placement
        by_fcl = fcl.distance(
            fcl.CollisionObject(shape.geometry, fcl.Transform(of_shape[:3, :3], of_shape[:3, 3])),
            fcl.CollisionObject(fcl.Sphere(0.05), fcl.Transform(np.eye(3), place)),
            fcl.DistanceRequest(enable_signed_distance=True), fcl.DistanceResult(),
        )  # fmt: skip
        assert by_mujoco == pytest.approx(by_coal, abs=1e-5)
        assert by_fcl == pytest.approx(by_coal, abs=1e-5)


def test_meshes_of_one_file_name_stay_apart(tmp_path: Path, rng: np.random.Generator) -> None:
    for folder, size in (("a", 0.3), ("b", 0.1)):
        (tmp_path / folder).mkdir()
        obj(tmp_path / folder / "link.obj", size * scattered(rng) / 0.2)
    other = '<collision><geometry><mesh filename="b/link.obj"/></geometry></collision></link>'
    path = write_edited(tmp_path / "v.urdf", VEHICLE, (DISC, '<mesh filename="a/link.obj"/>'), ("</link>", other))
    spec = read_spec(mujoco, path)
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    spec.compiler.boundmass = spec.compiler.boundinertia = 1e-6
    engine = spec.compile()
    assert engine.nmesh == 2
    sizes = [
        np.ptp(engine.mesh_vert[at : at + n]) for at, n in zip(engine.mesh_vertadr, engine.mesh_vertnum, strict=True)
    ]
    assert sizes[0] > 2.0 * sizes[1]
