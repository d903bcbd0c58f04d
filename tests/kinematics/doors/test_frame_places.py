"""Where a tip can touch what stands beside a door, and the tasks in which it cannot."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.collision.scene import CollisionScene
from doorman.exceptions import ScenarioError
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.scenario import Scenario

FEELS = {"mission.measures": ("poses", "attitude", "frame")}


@pytest.mark.parametrize("source, hand", [("push", 1.0), ("push_left", -1.0)])
def test_two_places_are_on_the_wall_far_apart_and_one_beside_the_hinge(source: str, hand: float) -> None:
    latch, hinge, beside = Model(Scenario.load(source, FEELS)).frame_places
    np.testing.assert_allclose(latch.point, [-0.1, hand * 1.68, 1.2], atol=1e-9)  # the URDF's walls are 0.8 m long
    np.testing.assert_allclose(hinge.point, [-0.1, hand * -0.48, 1.2], atol=1e-9)
    assert beside.point[1] == pytest.approx(0.0) and -0.12 < beside.point[0] < -0.03
    np.testing.assert_allclose([place.normal for place in (latch, hinge)], [[1.0, 0.0, 0.0]] * 2, atol=1e-9)
    np.testing.assert_allclose(beside.normal, [0.0, -hand, 0.0], atol=1e-9)


@pytest.mark.parametrize("source", ["push", "push_left", "push_small", "push_tilted"])
def test_disc_and_arm_are_clear_with_the_tip_on_each_place(source: str) -> None:
    model = Model(Scenario.load(source, FEELS))
    arm = [(link, "frame") for link in ("tip", "servo_1", "servo_2", "servo_3", "servo_4")]
    scene = CollisionScene(model.vehicle, model.door, arm[:1])
    disc = CollisionScene(model.vehicle, model.door, arm)
    for place in model.frame_places:
        rotation = rotation_body_to_world(np.array([0.0, 0.0, model.start_yaw + place.turn]))
        position = place.point - rotation @ model.vehicle.tip_position(model.start_arm)
        clearance = scene.min_clearance(position, rotation, model.start_arm, model.start_angle)
        assert clearance.distance > (0.0015 if place.turn else 0.009), clearance  # the rod 1 cm behind the tip
        clearance = disc.min_clearance(position, rotation, model.start_arm, model.start_angle)
        assert clearance.distance > 0.02, clearance
        assert clearance.distance == pytest.approx(place.clear, abs=0.06) and place.room >= 0.03


def test_no_place_where_it_is_not_asked_for() -> None:
    assert Model("push").frame_places == ()


@pytest.mark.parametrize(
    "source, changes, words",
    [
        ("sliding", {"contact.kind": "push"}, "plumb hinge"),
        ("hatch", {"contact.kind": "push"}, "plumb hinge"),
        ("paper", {}, "contact.kind"),
        ("push", {"mission.start": "contact"}, "mission.start"),
        ("push", {"start.door_angle": 1.2}, "starts closed"),
        ("push", {"start.arm": [0.0, 1.0, 0.3, -1.3]}, "start.arm"),
        ("push", {"estimation.door_place_deviation": 0.0}, "deviation"),
    ],
)
def test_a_task_that_cannot_use_the_frame_is_refused(source: str, changes: dict[str, object], words: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        Model(Scenario.load(source, changes | FEELS))
    assert refused.value.field == "mission.measures" and words in str(refused.value.allowed)
