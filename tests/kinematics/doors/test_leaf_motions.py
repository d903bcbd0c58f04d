"""Leaves on hinges that stand, lean or lie, and on slides: places, levers, inertia and weight, against Pinocchio."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pinocchio
import pytest
from leaves import LEAVES, LIMITS, Leaf, write_leaf

from doorman.exceptions import ScenarioError
from doorman.kinematics.doors.door import Door
from doorman.kinematics.doors.leaf.leaf_motion import SLIDE_RADIUS
from doorman.kinematics.doors.reading import read_door
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.scenario import DoorSection, Scenario

OPENINGS = (0.0, 0.15, 0.34)
PLACE = (0.5, 0.3)
"""Of the contact: distance from the hinge, and height."""


@pytest.fixture(scope="module", params=LEAVES)
def kind(request: pytest.FixtureRequest) -> Leaf:
    return LEAVES[request.param]


@pytest.fixture(scope="module")
def door(kind: Leaf, tmp_path_factory: pytest.TempPathFactory) -> Door:
    path = write_leaf(tmp_path_factory.mktemp("leaf") / "leaf.urdf", kind)
    return Door(path, DoorSection(closed=kind.closed), "push" if kind.side == "push" else "pull")


def test_the_contact_moves_with_the_leaf(door: Door) -> None:
    fixed = [door.link_placements(door.angle_of_opening(opening))["leaf"] for opening in OPENINGS]
    first = door.angle_of_opening(OPENINGS[0])
    point, normal = door.contact_point(first, *PLACE), door.normal(first)
    for opening, placement in zip(OPENINGS, fixed, strict=True):
        angle = door.angle_of_opening(opening)
        moved = placement @ np.linalg.inv(fixed[0])
        np.testing.assert_allclose(door.contact_point(angle, *PLACE), moved[:3, :3] @ point + moved[:3, 3], atol=1e-9)
        np.testing.assert_allclose(door.normal(angle), moved[:3, :3] @ normal, atol=1e-9)
        np.testing.assert_allclose(
            np.cross(*door.face(angle)), np.cross(*door.face(first)) @ moved[:3, :3].T, atol=1e-9
        )
        assert door.angle_of(door.contact_point(angle, *PLACE) - door.hinge_position) == pytest.approx(angle, abs=1e-9)
        assert door.opening_of(angle) == pytest.approx(opening)


def test_levers_are_slopes(door: Door) -> None:
    for opening in OPENINGS:
        angle, step = door.angle_of_opening(opening), 1e-6
        ahead, behind = (door.contact_point(angle + s, *PLACE) for s in (step, -step))
        np.testing.assert_allclose(door.lever(angle, PLACE[0]), (ahead - behind) / (2 * step), atol=1e-8)
        assert door.lever(angle, PLACE[0]) @ -door.normal(angle) == pytest.approx(door.lever_length(PLACE[0]))


def test_the_face_that_is_touched_is_the_leafs(door: Door) -> None:
    """A thin slice of the box lies behind it, and nothing before it."""
    angle = door.angle_of_opening(0.2)
    placement, normal = door.link_placements(angle)["leaf"], door.normal(angle)
    at = placement[:3, :3].T @ (door.contact_point(angle, *PLACE) - placement[:3, 3]) - [0.4, 0.01, 0.3]
    inwards = placement[:3, :3].T @ normal
    half = np.array([0.4, 0.015, 0.3])
    assert (np.abs(at) <= half + 1e-9).all() and not (np.abs(at - 1e-6 * inwards) <= half).all()


def test_heading_looks_along_the_normal(door: Door) -> None:
    for opening in OPENINGS:
        angle = door.angle_of_opening(opening)
        ahead = rotation_body_to_world([0.0, 0.0, door.heading(angle)])[:, 0]
        level = door.normal(angle) * [1.0, 1.0, 0.0]
        np.testing.assert_allclose(ahead, level / np.linalg.norm(level), atol=1e-9)


def test_weight_and_inertia_are_pinocchios(door: Door) -> None:
    data = door.model.createData()
    for opening in OPENINGS:
        angle, step = door.angle_of_opening(opening), 1e-5
        energies = [
            pinocchio.computePotentialEnergy(door.model, data, np.array([door.joint_value(angle + s)]))
            for s in (step, -step)
        ]
        assert door.weight_torque(angle) == pytest.approx((energies[0] - energies[1]) / (2 * step), abs=1e-6)
        inertia = pinocchio.crba(door.model, data, np.array([door.joint_value(angle)]))[0, 0]
        assert door.inertia == pytest.approx(inertia * door.joint_rate(1.0) ** 2)


def test_torques_of_the_joint_do_the_same_work(kind: Leaf, door: Door) -> None:
    assert door.joint_torque(2.0) * door.joint_rate(0.3) == pytest.approx(2.0 * 0.3)
    arm = SLIDE_RADIUS if kind.joint == "prismatic" else 1.0
    assert (door.friction, door.damping) == pytest.approx((0.8 * arm, 0.5 * arm**2))
    assert door.largest_opening == pytest.approx(LIMITS[kind.joint][1] - kind.closed)
    assert door.slides is (kind.joint == "prismatic")
    assert door.vertical is (not door.slides and not any(kind.rpy[:2]))


def test_the_planners_equations_are_those_of_the_door(kind: Leaf, door: Door, rng: np.random.Generator) -> None:
    model = Model(_scenario(kind, door.urdf))
    door = model.door
    for _ in range(5):
        angle = float(rng.uniform(*sorted((model.travel.start, model.travel.goal))))
        x = np.array(
            [*rng.uniform(-0.3, 0.3, 2), door.heading(angle), angle, rng.normal(), *rng.uniform(-1, 1, model.n_arm)]
        )
        u = np.concatenate([[30.0], rng.normal(size=3 + model.n_arm)])
        force = u[0] * rotation_body_to_world(x[:3])[:, 2] - [0.0, 0.0, model.vehicle.mass * 9.81]
        torque = door.lever(angle, model.coupling.distance_from_hinge) @ force - door.hinge_torque(angle, x[4])
        assert model.derivative(x, u)[4] == pytest.approx(torque / door.inertia, abs=1e-9)


def test_rows_are_distances_of_the_disc(kind: Leaf, door: Door) -> None:
    """The rim's nearest of many points to leaf's plane and wall."""
    model = Model(_scenario(kind, door.urdf))
    door, radius, turns = model.door, model.vehicle.radius, np.linspace(0.0, 2.0 * math.pi, 20001)
    x = model.on_the_way(0.5 * (model.travel.start + model.travel.goal))
    x[:2] = 0.1, -0.15
    place = model.coupling.vehicle_position(x[:3], float(x[3]), x[5:])
    rim = place + radius * np.column_stack([np.cos(turns), np.sin(turns), 0 * turns]) @ rotation_body_to_world(x[:3]).T
    normal, contact = door.normal(float(x[3])), model.coupling.contact_point(float(x[3]))
    rows = dict(zip(model.constraint_names, model.constraints(x), strict=True))
    assert rows["disc clear of leaf"] == pytest.approx(((rim - contact) @ normal).max(), abs=1e-6)
    if "disc clear of wall" in rows:
        into = (rim - door.hinge_position) @ door.into
        assert rows["disc clear of wall"] == pytest.approx(into.max() + door.frame_depth, abs=1e-6)


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"start.door_angle": 1.2}, "start.door_angle"), ({"goal.door_angle": 1.2}, "goal.door_angle"),
        ({"door.rest_angle": 0.3}, "door.rest_angle"), ({"simulation.door_width": 1.0}, "simulation.door_width"),
    ],
)  # fmt: skip
def test_a_slide_has_nothing_that_only_a_hinge_has(changes: dict[str, float], field: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        Model(Scenario.load("shipped:drawer", changes))
    assert caught.value.field == field and caught.value.allowed


def _scenario(kind: Leaf, urdf: Path) -> Scenario:
    return Scenario.load(
        "shipped:paper",
        {
            "door.urdf": str(urdf), "door.closed": kind.closed, "contact.side": kind.side, "start.door_angle": None,
            "contact.distance_from_hinge": 0.5, "contact.height": 0.3, "goal.door_angle": None, "goal.opening": 0.3,
        },
    )  # fmt: skip


def test_a_slide_is_closed_at_zero_where_its_range_holds_that(tmp_path: Path) -> None:
    door = Door(write_leaf(tmp_path / "leaf.urdf", LEAVES["drawer"]))
    assert (door.closed, door.closed_is_guessed) == (0.0, False)


@pytest.mark.parametrize(("source", "words"), [("drawer", "0.120 m"), ("sliding", "0.120 m"), ("hatch", "96.9°")])
def test_places_are_said_in_the_unit_of_the_joint(source: str, words: str) -> None:
    door = read_door(Scenario.load(f"shipped:{source}"))
    assert door.in_words(door.angle_of_opening(0.12)) == words
    assert door.in_words(door.angle_of_opening(-1e-12)) in ("0.000 m", "90.0°")
