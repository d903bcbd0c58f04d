"""What counts as the tip: shapes at whose hull the tip's frame is, in the scene as in the plant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from urdf_variants import robot_data_vehicle
from vehicles_with_blunt_tips import TIP_AT, write_with_end

from doorman.collision.scene import CollisionScene
from doorman.collision.shapes import read_shapes, tip_shapes
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.model import Model

ENDS = [
    ("box", {"size": "0.06 0.03 0.02"}, 0.03), ("sphere", {"radius": "0.02"}, 0.02),
    ("cylinder", {"radius": "0.02", "length": "0.05"}, 0.02), ("mesh", {"size": "0.06 0.03 0.02"}, 0.03),
]  # fmt: skip
"""A shape, and half its length along the arm."""


def names(path: Path) -> set[str]:
    return {read_shapes(path)[index].name for index in tip_shapes(Vehicle(path))}


@pytest.mark.parametrize(("kind", "size", "half"), ENDS)
@pytest.mark.parametrize(("beyond", "counts"), [(0.005, True), (0.0, True), (-0.005, True), (-0.03, False)])
def test_a_hull_that_the_tip_is_at_is_the_tip(
    tmp_path: Path, kind: str, size: dict[str, str], half: float, beyond: float, counts: bool
) -> None:
    """`beyond` is how far it reaches beyond the tip: what ends farther before it than half its thickness is none."""
    path = write_with_end(tmp_path / "vehicle.urdf", kind, size, TIP_AT + beyond - half)
    assert names(path) == ({"tip", "servo_4/end"} if counts else {"tip"})


def test_what_moves_against_the_tip_is_none(tmp_path: Path) -> None:
    long = write_with_end(tmp_path / "vehicle.urdf", "box", {"size": "0.8 0.03 0.02"}, 0.124, link="servo_3")
    assert names(long) == {"tip"}


def test_the_scene_lets_it_touch_the_leaf_and_nothing_else(tmp_path: Path, model: Model) -> None:
    path = write_with_end(tmp_path / "vehicle.urdf", *ENDS[0][:2], TIP_AT - 0.02)
    pairs = CollisionScene(Vehicle(path), model.door).pairs
    assert ("servo_4/end", "leaf/leaf") not in pairs and ("servo_4/end", "frame/jamb_latch") in pairs
    assert ("servo_4/0", "leaf/leaf") in pairs  # the rod of the same link


@pytest.mark.parametrize(
    ("name", "link"),
    [("borinot_flying_arm_2", "flying_arm_2__link2"), ("hextilt_flying_arm_5", "flying_arm_5__link_5")],
)
def test_last_links_of_example_robot_data_are_tips(name: str, link: str) -> None:
    """Their meshes reach 4 and 6 mm beyond the tip's frame; borinot's frame lies 2.6 mm beside its nut."""
    path, section = robot_data_vehicle(name)
    vehicle = Vehicle(path, section)
    (index,), (link_in_tip,) = zip(*tip_shapes(vehicle).items(), strict=True)
    assert read_shapes(path)[index].link == link
    arm = np.full(vehicle.n_arm, 0.3)
    tip = vehicle.link_placements(arm)[section.tip]
    np.testing.assert_allclose(tip @ link_in_tip, vehicle.link_placements(arm)[link], atol=1e-12)
