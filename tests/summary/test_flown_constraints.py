"""The planner's rows from true positions: the planner's own where the tip is at the door, and distances of shapes elsewhere."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman import Model
from doorman.collision.scene import CollisionScene
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.summary.flown_constraints import flown_constraints
from doorman.visualization.scene.moments import Moment
from doorman.visualization.scene.surfaces import clearances as drawn


def rows(model: Model, position, attitude, angle: float, arm=None) -> np.ndarray:
    arm = model.goal_arm if arm is None else arm
    one = [np.atleast_2d(np.asarray(value, dtype=float)) for value in (position, attitude, arm)]
    return flown_constraints(model, one[0], one[1], np.array([angle]), one[2])[0]


def test_at_the_door_they_are_the_planners(model: Model, rng: np.random.Generator) -> None:
    compared = 0
    for _ in range(200):
        angle = rng.uniform(0.2, math.pi / 2)
        attitude = np.append(rng.uniform(-0.3, 0.3, 2), angle - math.pi / 2 + rng.uniform(-0.4, 0.4))
        arm = model.goal_arm + rng.uniform(-0.3, 0.3, model.n_arm)
        planned = model.constraints([*attitude, angle, 0.0, *arm])
        found = rows(model, model.coupling.vehicle_position(attitude, angle, arm), attitude, angle, arm)
        counts = np.isfinite(found)
        assert counts[:-2].all(), "the tip is at the door: arm and leaf count"
        np.testing.assert_allclose(found[counts], planned[counts], atol=1e-9)
        compared += counts.all()
    assert compared > 50


LEVEL = (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("place", "angle", "row", "expected"),
    [
        ((-0.5, 0.6, 1.0), math.pi / 2, "disc clear of leaf", -0.1),
        ((-0.3, 0.6, 1.0), math.pi / 2, "disc clear of leaf", 0.1),
        ((-0.3, 1.7, 1.0), math.pi / 2, "disc clear of leaf", -math.inf),  # beyond the latch
        ((-0.3, -0.5, 1.0), math.pi / 2, "disc clear of leaf", -math.inf),  # beyond the hinge
        ((0.6, 0.3, 1.0), 0.0, "disc clear of leaf", 0.1),  # beside a leaf that stands at a right angle to the wall
        ((0.0, 0.9, 1.0), 0.0, "disc clear of latch jamb", 0.1),
        ((0.0, 0.3, 1.0), 0.0, "disc clear of hinge jamb", 0.1),
        ((-0.6, 0.9, 1.0), 0.0, "disc clear of latch jamb", -math.inf),  # before the frame
        ((0.5, 0.9, 1.0), 0.0, "disc clear of latch jamb", -math.inf),  # through it
    ],
)
def test_a_row_counts_where_it_says_something(model: Model, place, angle: float, row: str, expected: float) -> None:
    found = rows(model, model.door.hinge_position * [1, 1, 0] + place, LEVEL, angle)
    assert found[model.constraint_names.index(row)] == pytest.approx(expected, abs=1e-12)


def test_a_tilted_disc_needs_less_room(model: Model) -> None:
    """Seen along the leaf's normal, its half width is R cos θ."""
    leaf = model.constraint_names.index("disc clear of leaf")
    found = rows(model, [-0.5, 0.6, 1.4], [0.0, 0.4, 0.0], math.pi / 2)[leaf]
    assert found == pytest.approx(model.vehicle.radius * math.cos(0.4) - 0.5)


def test_an_arm_above_the_body_counts_in_the_air(model: Model) -> None:
    up = np.array([0.0, -1.5, 0.0, 0.0])
    found = rows(model, [-5.0, 0.6, 1.4], LEVEL, math.pi / 2, up)
    points = len(model.vehicle.point_names)
    assert found.max() == found[:points].max()
    np.testing.assert_allclose(found[:points], model.constraints([*LEVEL, math.pi / 2, 0.0, *up])[:points])


def test_a_door_that_truly_stands_elsewhere_counts_where_it_is(model: Model) -> None:
    """A vehicle that is moved and turned with the door has the same rows and clearances; a proud face is nearer by as much."""
    offset, yaw, face = np.array([0.05, -0.03, 0.02]), 0.2, 0.04
    elsewhere = {"simulation.door_offset": offset, "simulation.door_yaw": yaw}
    moved = Model(model.scenario.replace(elsewhere))
    proud = Model(model.scenario.replace({**elsewhere, "simulation.door_face_offset": face}))
    turn, hinge = rotation_body_to_world([0.0, 0.0, yaw]), model.door.hinge_position
    leaf = model.constraint_names.index("disc clear of leaf")
    for place, angle in (((-0.45, 0.6, 1.0), 1.5), ((0.05, 0.75, 1.0), 0.6)):
        there = hinge + offset + turn @ place
        plain, level = rows(model, hinge + place, LEVEL, angle), (0.0, 0.0, yaw)
        np.testing.assert_allclose(rows(moved, there, level, angle), plain, atol=1e-12)
        assert np.abs(rows(model, there, level, angle) - plain)[leaf] > 5e-3
        assert rows(proud, there, level, angle)[leaf] == pytest.approx(plain[leaf] + face)
        exact = [
            CollisionScene(one.vehicle, one.true_door).min_clearance(where, rotation, one.goal_arm, angle)
            for one, where, rotation in ((model, hinge + place, np.eye(3)), (moved, there, turn))
        ]
        assert exact[0].distance == pytest.approx(exact[1].distance, abs=1e-4)  # FCL's accuracy
        moment = [
            Moment(0.0, where, np.array(attitude), angle, model.goal_arm, None, None, "", "")
            for where, attitude in ((hinge + place, LEVEL), (there, level))
        ]
        np.testing.assert_allclose(drawn(moved, moment[1]), drawn(model, moment[0]), atol=1e-12)
        assert drawn(proud, moment[1])[0] == pytest.approx(drawn(model, moment[0])[0] - face)
