"""Doors whose URDF says what cannot be flown: latched, coupled, or on a hinge that lies."""

from __future__ import annotations

from pathlib import Path

import pytest
from urdf_variants import DOOR, write_edited

from doorman.exceptions import UrdfError
from doorman.kinematics.doors.door import Door
from doorman.scenario import DoorSection

END = "</robot>"
HINGE = '<joint name="hinge" type="revolute">'
LIMIT = '<limit lower="-1.5" upper='


def extra(name: str, kind: str, parent: str, inside: str = "") -> str:
    """A link on a joint of its own."""
    limit = '<axis xyz="0 1 0"/><limit lower="0" upper="0.8" effort="5" velocity="3"/>' if kind != "floating" else ""
    return (
        f'<link name="{name}_link"/><joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{name}_link"/>'
        f"{limit}{inside}</joint>"
    )


def door(tmp_path: Path, *edits: tuple[str, str]) -> Path:
    return write_edited(tmp_path / "door.urdf", DOOR, *edits)


def refused(path: Path, field: str, words: str) -> UrdfError:
    with pytest.raises(UrdfError, match=words) as caught:
        Door(path)
    assert caught.value.file == str(path)
    assert caught.value.field == field
    assert caught.value.given is not None and caught.value.allowed
    return caught.value


def limits(lower: float, upper: float) -> tuple[str, str]:
    """An edit of the hinge's range."""
    text = DOOR.read_text(encoding="utf-8")
    line = text[text.index("<limit ") : text.index("/>", text.index("<limit ")) + 2]
    return line, f'<limit lower="{lower}" upper="{upper}" effort="0" velocity="10"/>'


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "continuous", "floating"])
def test_what_moves_on_the_leaf_latches_it(tmp_path, kind):
    assert refused(door(tmp_path, (END, extra("lever", kind, "leaf") + END)), "joint lever", "latched").given == kind


def test_what_moves_on_a_part_of_the_leaf_latches_it_too(tmp_path):
    parts = extra("plate", "fixed", "leaf") + extra("bolt", "prismatic", "plate_link")
    refused(door(tmp_path, (END, parts + END)), "joint bolt", "latched")


def test_a_lever_that_opens_no_latch_stands(tmp_path):
    """Said by the scenario; the lever's joint may have the name of the leaf's link, which Pinocchio cannot tell apart."""
    unlatched = DoorSection(latched=False)
    for name in ("lever", "leaf"):
        file = door(tmp_path, (END, extra(name, "revolute", "leaf") + END))
        found = Door(file, unlatched)
        assert found.standing_joints == (name,) and found.width == Door(DOOR).width


def test_tags_of_other_programs_are_read_over(tmp_path):
    """As urdfdom does, which knows no namespaces."""
    foreign = "<drake:compliance><drake:friction value='1'/></drake:compliance>"
    assert Door(door(tmp_path, (END, foreign + END))).width == Door(DOOR).width


def test_what_is_fixed_to_the_leaf_does_not(tmp_path):
    assert Door(door(tmp_path, (END, extra("lever", "fixed", "leaf") + END))).standing_joints == ()


def test_a_hinge_on_a_slide_is_refused(tmp_path):
    slide = extra("slide", "prismatic", "frame")
    path = door(tmp_path, ('<parent link="frame"/>', '<parent link="slide_link"/>'), (END, slide + END))
    refused(path, "joint slide", "hangs on another joint")


def test_a_second_leaf_stands_still(tmp_path):
    assert Door(door(tmp_path, (END, extra("second", "revolute", "frame") + END))).standing_joints == ("second",)


@pytest.mark.parametrize("through", [False, True])
def test_a_second_leaf_that_follows_is_refused(tmp_path, through):
    second = extra("second", "revolute", "frame", '<mimic joint="hinge" multiplier="-1"/>')
    third = extra("astragal", "revolute", "frame", '<mimic joint="second"/>') if through else ""
    refused(
        door(tmp_path, (END, second + third + END)),
        f"joint {'astragal' if through else 'second'}/mimic",
        "follows the hinge",
    )


def test_a_hinge_that_follows_is_refused(tmp_path):
    path = door(tmp_path, (HINGE, HINGE + '<mimic joint="crank"/>'), (END, extra("crank", "revolute", "frame") + END))
    refused(path, "joint hinge/mimic", "the hinge follows")


@pytest.mark.parametrize("angle", [0.0, 1.2])
def test_a_hinge_without_a_range_is_refused(tmp_path, angle):
    refused(door(tmp_path, limits(angle, angle)), "joint hinge/limit@upper", "no range")


@pytest.mark.parametrize("axis", ["0 0.01 1", "1 0 1"])
def test_a_hinge_askew_to_its_leaf_is_refused(tmp_path, axis):
    path = door(tmp_path, ('<axis xyz="0 0 1"/>', f'<axis xyz="{axis}"/>'))
    refused(path, "link leaf/collision", "upright")


@pytest.mark.parametrize("axis", ["0 0 1", "1 0 -0.7"])
def test_a_steep_slide_is_refused(tmp_path, axis):
    path = door(
        tmp_path, (HINGE, HINGE.replace("revolute", "prismatic")), ('<axis xyz="0 0 1"/>', f'<axis xyz="{axis}"/>')
    )
    refused(path, "joint hinge", "too steep")


def test_a_slide_is_not_made_wider(tmp_path):
    path = door(
        tmp_path, (HINGE, HINGE.replace("revolute", "prismatic")), ('<axis xyz="0 0 1"/>', '<axis xyz="1 0 0"/>')
    )
    with pytest.raises(UrdfError, match="wider") as caught:
        Door(path, DoorSection(width=1.5))
    assert caught.value.field == "door.width"


def test_a_leaf_that_leans_is_refused(tmp_path):
    old = '<origin xyz="0.6 -0.02 0.8" rpy="0 0 0"/>\n      <geometry><box size="1.2 0.04 1.6"/></geometry>\n    </collision>'
    refused(door(tmp_path, (old, old.replace("0 0 0", "0 0.1 0"))), "link leaf/collision", "upright")


def test_closed_outside_the_range_is_refused():
    with pytest.raises(UrdfError, match="closed outside") as caught:
        Door(DOOR, DoorSection(closed=2.0))
    assert caught.value.field == "door.closed"
