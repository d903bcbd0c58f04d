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


def extra(name: str, kind: str, parent: str, inside: str = "") -> str:
    """A link on a joint of its own."""
    limit = '<axis xyz="0 1 0"/><limit lower="0" upper="0.8" effort="5" velocity="3"/>' if kind != "floating" else ""
    return (
        f'<link name="{name}_link"/><joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{name}_link"/>'
        f"{limit}{inside}</joint>"
    )


def door(tmp_path: Path, *edits: tuple[str, str]) -> Path:
    return write_edited(tmp_path / "door.urdf", DOOR, *edits)


def limits(lower: float, upper: float) -> tuple[str, str]:
    """An edit of the hinge's range."""
    text = DOOR.read_text(encoding="utf-8")
    line = text[text.index("<limit ") : text.index("/>", text.index("<limit ")) + 2]
    return line, f'<limit lower="{lower}" upper="{upper}" effort="0" velocity="10"/>'


SLIDES = (HINGE, HINGE.replace("revolute", "prismatic"))
AXIS = '<axis xyz="0 0 1"/>'
BOX = (
    '<origin xyz="0.6 -0.02 0.8" rpy="0 0 0"/>\n      <geometry><box size="1.2 0.04 1.6"/></geometry>\n    </collision>'
)
BOLT = extra("plate", "fixed", "leaf") + extra("bolt", "prismatic", "plate_link")
SECOND = extra("second", "revolute", "frame", '<mimic joint="hinge" multiplier="-1"/>')
ASTRAGAL = extra("astragal", "revolute", "frame", '<mimic joint="second"/>')
REFUSED = [
    *(([(END, extra("lever", kind, "leaf") + END)], "joint lever", "latched", kind)
      for kind in ("revolute", "prismatic", "continuous", "floating")),
    ([(END, BOLT + END)], "joint bolt", "latched", "prismatic"),
    ([('<parent link="frame"/>', '<parent link="slide_link"/>'), (END, extra("slide", "prismatic", "frame") + END)],
     "joint slide", "hangs on another joint", "prismatic"),
    ([(END, SECOND + END)], "joint second/mimic", "follows the hinge", "hinge"),
    ([(END, SECOND + ASTRAGAL + END)], "joint astragal/mimic", "follows the hinge", "hinge"),
    ([(HINGE, HINGE + '<mimic joint="crank"/>'), (END, extra("crank", "revolute", "frame") + END)],
     "joint hinge/mimic", "the hinge follows", "crank"),
    ([limits(0.0, 0.0)], "joint hinge/limit@upper", "no range", 0.0),
    ([(AXIS, '<axis xyz="0 0.01 1"/>')], "link leaf/collision", "upright", None),
    ([(AXIS, '<axis xyz="1 0 1"/>')], "link leaf/collision", "upright", None),
    ([SLIDES], "joint hinge", "too steep", None),
    ([SLIDES, (AXIS, '<axis xyz="1 0 -0.7"/>')], "joint hinge", "too steep", None),
    ([(BOX, BOX.replace("0 0 0", "0 0.1 0"))], "link leaf/collision", "upright", None),
]  # fmt: skip


@pytest.mark.parametrize(("edits", "field", "words", "given"), REFUSED)
def test_what_cannot_be_opened_is_refused(tmp_path, edits, field, words, given):
    path = door(tmp_path, *edits)
    with pytest.raises(UrdfError, match=words) as caught:
        Door(path)
    assert (caught.value.file, caught.value.field) == (str(path), field)
    assert caught.value.allowed and (caught.value.given is not None if given is None else caught.value.given == given)


@pytest.mark.parametrize(("section", "field", "words"), [
    (DoorSection(width=1.5), "door.width", "wider"), (DoorSection(closed=2.0), "door.closed", "closed outside"),
])  # fmt: skip
def test_a_section_that_does_not_fit_is_refused(tmp_path, section, field, words):
    slide = door(tmp_path, SLIDES, (AXIS, '<axis xyz="1 0 0"/>'))
    with pytest.raises(UrdfError, match=words) as caught:
        Door(slide if section.width else DOOR, section)
    assert caught.value.field == field


def test_a_lever_that_opens_no_latch_stands(tmp_path):
    """Said by the scenario; the lever's joint may have the name of the leaf's link, which Pinocchio cannot tell apart."""
    for name in ("lever", "leaf"):
        found = Door(door(tmp_path, (END, extra(name, "revolute", "leaf") + END)), DoorSection(latched=False))
        assert found.standing_joints == (name,) and found.width == Door(DOOR).width


def test_tags_of_other_programs_are_read_over(tmp_path):
    """As urdfdom does, which knows no namespaces."""
    foreign = "<drake:compliance><drake:friction value='1'/></drake:compliance>"
    assert Door(door(tmp_path, (END, foreign + END))).width == Door(DOOR).width


@pytest.mark.parametrize(("kind", "parent", "stands"), [("fixed", "leaf", ()), ("revolute", "frame", ("other",))])
def test_what_is_fixed_to_the_leaf_or_beside_it_does_not_latch_it(tmp_path, kind, parent, stands):
    assert Door(door(tmp_path, (END, extra("other", kind, parent) + END))).standing_joints == stands
