"""The FCL scene: known distances, a second opinion by coal, bad input."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import coal
import numpy as np
import pinocchio
import pytest
from urdf_variants import VEHICLE, robot_data_vehicle, write_edited

from doorman.collision.scene import CollisionScene
from doorman.collision.shapes import read_shapes, tip_link
from doorman.exceptions import DimensionError, UrdfError
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.model import Model
from doorman.scenario import VehicleSection

ACCURACY = 5e-4  # FCL's, for a cylinder against a box
LEVEL = np.eye(3)
ARM_AHEAD = np.zeros(4)


@pytest.fixture(scope="module")
def scene(model: Model) -> CollisionScene:
    return CollisionScene(model.vehicle, model.door)


def test_tip_may_touch_the_leaf_and_nothing_else_may(scene: CollisionScene) -> None:
    vehicle = ("base_link", "servo_2", "servo_3", "servo_4", "tip")
    frame = ("jamb_hinge", "jamb_latch", "lintel", "sill", "wall_hinge", "wall_latch", "wall_above", "floor")
    door = ("leaf/leaf", *(f"frame/{name}" for name in frame))
    expected = set(product(vehicle, door)) - {("tip", "leaf/leaf")}
    expected |= {(link, "base_link") for link in ("servo_2", "servo_3", "servo_4", "tip")}
    assert set(scene.pairs) == expected
    assert len(scene.pairs) == len(expected)


@pytest.mark.parametrize("gap", [0.08, 0.01, 0.001, -0.001, -0.06])
def test_disc_beside_the_latch_jamb(scene: CollisionScene, gap: float) -> None:
    position = [-0.06, 1.2 - 0.4 - gap, 1.3]
    clearance = scene.min_clearance(position, LEVEL, ARM_AHEAD, 0.0)
    assert (clearance.first, clearance.second) == ("base_link", "frame/jamb_latch")
    assert clearance.distance == pytest.approx(gap, abs=ACCURACY)
    overlaps = scene.collides(position, LEVEL, ARM_AHEAD, 0.0)
    assert [(pair.first, pair.second) for pair in overlaps] == ([] if gap > 0 else [("base_link", "frame/jamb_latch")])


def test_arm_folded_up_goes_through_the_rotors(scene: CollisionScene) -> None:
    overlaps = scene.collides([-1.5, 0.6, 1.3], LEVEL, [0.0, 1.3, 1.3, 0.0], 0.3)
    assert ("servo_4", "base_link") in [(pair.first, pair.second) for pair in overlaps]
    depths = [pair.distance for pair in overlaps]
    assert depths == sorted(depths)
    assert depths[-1] < 0.0


def test_agrees_with_coal_on_shapes_read_by_pinocchio(
    scene: CollisionScene, model: Model, rng: np.random.Generator
) -> None:
    """Another library, another reader of the URDF, another way to the placements, and no culling."""
    opinion = _SecondOpinion(model)
    n = 120
    positions = rng.uniform([-0.9, -0.2, 0.7], [0.9, 1.4, 2.0], (n, 3))
    attitudes = rng.uniform(-0.6, 0.6, (n, 3)) + np.array([0.0, 0.0, -0.6])
    arms = rng.uniform(model.vehicle.lower_limits, model.vehicle.upper_limits, (n, 4))
    doors = rng.uniform(-0.5, 1.6, n)
    rotations = np.array([rotation_body_to_world(attitude) for attitude in attitudes])
    found = scene.min_clearance_along(positions, rotations, arms, doors)
    expected = np.array([opinion.clearance(*x) for x in zip(positions, rotations, arms, doors, strict=True)])
    assert 20 < (expected < 0.0).sum() < n - 20
    np.testing.assert_allclose(found.distances, expected, atol=ACCURACY)


def test_many_states_are_as_each_alone(scene: CollisionScene, model: Model) -> None:
    share = np.linspace(0.0, 1.0, 12)[:, None]
    states = (1 - share) * model.start_state + share * model.goal_state
    positions = np.array([model.coupling.vehicle_position(x[:3], x[3], x[5:]) for x in states])
    rotations = np.array([rotation_body_to_world(x[:3]) for x in states])
    along = scene.min_clearance_along(positions, rotations, states[:, 5:], states[:, 3])
    for k, x in enumerate(states):
        alone = scene.min_clearance(positions[k], rotations[k], x[5:], x[3])
        assert alone.distance == along.distances[k]
        assert (alone.first, alone.second) == along.pairs[k]
    assert along.worst.distance == along.distances.min()
    assert not along.distances.flags.writeable


def test_tip_named_by_its_joint_is_the_same_tip(model: Model) -> None:
    vehicle = Vehicle(VEHICLE, VehicleSection(tip="tip_mount"))
    assert tip_link(vehicle) == "tip"
    assert ("tip", "leaf/leaf") not in CollisionScene(vehicle, model.door).pairs


def test_meshes_become_convex_hulls(model: Model) -> None:
    path, names = robot_data_vehicle("borinot_flying_arm_2")
    vehicle = Vehicle(path, names)
    scene = CollisionScene(vehicle, model.door)
    far = scene.min_clearance([-1.5, 0.6, 1.3], LEVEL, np.zeros(vehicle.n_arm), 0.3)
    inside = scene.collides([0.0, 1.2, 1.3], LEVEL, np.zeros(vehicle.n_arm), 0.3)
    assert far.second == "borinot__base_link"  # the arm's second link passes 5 cm below the body
    assert 0.0 < far.distance < 0.1
    assert ("borinot__base_link", "frame/jamb_latch") in [(pair.first, pair.second) for pair in inside]
    for shape in scene.shapes:
        if shape.link in vehicle.link_placements(np.zeros(vehicle.n_arm)):
            assert shape.radius < 1.0


@pytest.mark.parametrize(
    ("argument", "value"),
    [
        (0, [0.0, np.nan, 1.0]),
        (0, [0.0, 1.0]),
        (1, np.full((3, 3), np.inf)),
        (1, np.eye(2)),
        (1, 1.1 * np.eye(3)),
        (1, [["a"]]),
        (2, [0.0, 0.0, 0.0]),
        (2, [0.0, 0.0, 0.0, np.nan]),
        (3, np.nan),
        (3, "open"),
    ],
)
def test_bad_poses_never_reach_fcl(scene: CollisionScene, argument: int, value: object) -> None:
    arguments: list[object] = [[-1.5, 0.6, 1.3], LEVEL, ARM_AHEAD, 0.3]
    arguments[argument] = value
    with pytest.raises(DimensionError):
        scene.min_clearance(*arguments)  # type: ignore[arg-type]
    with pytest.raises(DimensionError):
        scene.collides(*arguments)  # type: ignore[arg-type]


def test_arrays_of_unequal_length_are_refused(scene: CollisionScene) -> None:
    with pytest.raises(DimensionError, match="wrong shape"):
        scene.min_clearance_along(np.zeros((3, 3)), np.tile(LEVEL, (2, 1, 1)), np.zeros((3, 4)), np.zeros(3))
    with pytest.raises(DimensionError, match="at least one"):
        scene.min_clearance_along(np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros((0, 4)), np.zeros(0))


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ('<capsule radius="0.40" length="0.1"/>', "not a valid URDF"),
        ('<mesh filename="package://nowhere/disc.stl"/>', "no such mesh"),
        ('<mesh filename="hexarotor_arm.txt"/>', "cannot be read"),
    ],
)
def test_unusable_shape_is_an_error_that_names_it(tmp_path: Path, shape: str, message: str) -> None:
    (tmp_path / "hexarotor_arm.txt").write_text("no mesh")
    path = write_edited(tmp_path / "bad.urdf", VEHICLE, ('<cylinder radius="0.40" length="0.0004"/>', shape))
    with pytest.raises(UrdfError, match=message) as caught:
        read_shapes(path)
    assert "base_link" in str(caught.value) or "capsule" in str(caught.value)


def test_shapes_are_named_by_link_and_element(tmp_path: Path) -> None:
    disc = '<cylinder radius="0.40" length="0.0004"/></geometry>\n    </collision>'
    more = disc + '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
    named = write_edited(
        tmp_path / "named.urdf", VEHICLE, (disc, more), ("<collision>", '<collision name="rotor_disc">')
    )
    shapes = {shape.name: shape for shape in read_shapes(named)}
    assert {"base_link/rotor_disc", "base_link/1", "servo_4", "tip"} <= shapes.keys()
    assert shapes["base_link/1"].radius == pytest.approx(0.1 * np.sqrt(3.0))


def test_vehicle_without_shapes_is_refused(model: Model, tmp_path: Path) -> None:
    text = VEHICLE.read_text(encoding="utf-8").replace("<collision>", "<!--").replace("</collision>", "-->")
    path = tmp_path / "bare.urdf"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UrdfError, match="no collision shapes"):
        CollisionScene(Vehicle(path, VehicleSection(radius=0.4)), model.door)


class _SecondOpinion:
    """Smallest distance over the same pairs of links by coal, from Pinocchio's geometry models."""

    def __init__(self, model: Model) -> None:
        self._parts = []
        for path in (model.vehicle.urdf, model.door.urdf):
            tree = pinocchio.buildModelFromUrdf(str(path))
            shapes = pinocchio.buildGeomFromUrdf(tree, str(path), pinocchio.GeometryType.COLLISION)
            self._parts.append((tree, tree.createData(), shapes, shapes.createData()))

    def clearance(self, position: np.ndarray, rotation: np.ndarray, arm: np.ndarray, door_angle: float) -> float:
        body = pinocchio.SE3(rotation, position)
        vehicle = [(name, shape, body * placement) for name, shape, placement in self._placed(0, arm)]
        door = self._placed(1, np.array([door_angle]))
        pairs = [(a, b) for a, b in product(vehicle, door) if not (a[0] == "tip_0" and b[0] == "leaf_0")]
        base = next(item for item in vehicle if item[0] == "base_link_0")
        pairs += [(item, base) for item in vehicle if item is not base]
        return min(self._distance(a, b) for a, b in pairs)

    def _placed(self, part: int, q: np.ndarray) -> list[tuple[str, coal.CollisionGeometry, pinocchio.SE3]]:
        tree, data, shapes, shapes_data = self._parts[part]
        pinocchio.updateGeometryPlacements(tree, data, shapes, shapes_data, q)
        placements = [pinocchio.SE3(placement) for placement in shapes_data.oMg]
        objects = zip(shapes.geometryObjects, placements, strict=True)
        return [(item.name, item.geometry, placement) for item, placement in objects]

    @staticmethod
    def _distance(a: tuple, b: tuple) -> float:
        first, second = (coal.Transform3s(placement.rotation, placement.translation) for placement in (a[2], b[2]))
        return float(coal.distance(a[1], first, b[1], second, coal.DistanceRequest(), coal.DistanceResult()))
