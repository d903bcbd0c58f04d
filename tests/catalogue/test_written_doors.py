"""Sixty doors as other authors write them: read as they are, or asked about.

A draw knows where the hinge is, where the leaf points that is shut, how wide it is and which way it opens. The URDF says that in
one of many ways: with a base that stands anywhere, a joint whose zero is shut, half open or at a right angle, an axis up or down,
a leaf along any axis of its link, of one slab or of frame and panel, with handles of boxes, cylinders or links of their own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from doorman.exceptions import DoormanError
from doorman.feasibility.inputs.setup import setup_findings
from doorman.kinematics.doors.reading import read_door
from doorman.model import Model
from doorman.scenario import ContactSection, Scenario

_NAMES = (
    ("leaf", "hinge"),
    ("link_1", "joint_0"),
    ("door_panel", "door_hinge_joint"),
    ("Door", "Hinge"),
    ("blatt", "scharnier"),
)
_ROOTS = ("frame", "world", "base_link", "wall", "link_0")
ZEROS = ("shut", "shut", "right angle", "lower end", "upper end", "anywhere")
SHAPES = ("slab", "slab", "frame and panel", "two planks", "glazed")
HANDLES = ("none", "box", "cylinder", "link", "both sides")


@dataclass(frozen=True)
class WrittenDoor:
    """One draw."""

    names: tuple[str, str]
    root: str
    hinge: tuple[float, float, float]
    """On the axis, at the leaf's lower edge, world frame [m]."""
    azimuth: float
    """Of the closed leaf, from hinge to latch [rad]."""
    opens: float
    """1 where it opens counter-clockwise, seen from above."""
    width: float
    height: float
    zero: str
    shape: str
    handle: str
    framed: bool
    base: bool
    """Whether the root is another link, from which the frame stands somewhere."""
    turned_over: bool
    """Whether the joint's frame is upside down."""
    in_link: int
    """Quarter turns of the leaf in its link."""
    axis: float
    knuckle: float
    """How far the axis lies before the middle of the leaf [m]."""
    extras: bool
    """Whether another joint of the same file moves, and what is not used has no effort or reversed limits."""

    @classmethod
    def drawn(cls, number: int) -> WrittenDoor:
        """The draw of a number."""
        rng = np.random.default_rng([number, 72])

        def one(values: tuple[str, ...]) -> str:
            return values[int(rng.integers(len(values)))]

        return cls(
            _NAMES[int(rng.integers(len(_NAMES)))], one(_ROOTS),
            (float(rng.uniform(-2, 2)), float(rng.uniform(-2, 2)), float(rng.uniform(0.0, 0.05))),
            float(rng.uniform(-math.pi, math.pi)), float(rng.choice([-1.0, 1.0])), float(rng.uniform(0.6, 1.3)),
            float(rng.uniform(1.6, 2.2)), one(ZEROS), one(SHAPES), one(HANDLES), bool(rng.random() < 0.7),
            bool(rng.random() < 0.4), bool(rng.random() < 0.25), int(rng.integers(4)), float(rng.choice([-1.0, 1.0])),
            float(rng.uniform(-0.02, 0.02)), bool(rng.random() < 0.4),
        )  # fmt: skip

    @property
    def closed(self) -> float:
        """Value of the joint where the door is shut [rad]."""
        grows = self._grows
        return {
            "shut": 0.0, "right angle": 0.5 * math.pi, "lower end": 0.0 if grows > 0 else 1.6,
            "upper end": 0.0 if grows < 0 else -1.6, "anywhere": 0.37,
        }[self.zero]  # fmt: skip

    @property
    def _grows(self) -> float:
        """1 where the joint's value grows as the door opens."""
        return self.opens * self.axis * (-1.0 if self.turned_over else 1.0)

    def write(self, path: Path) -> Path:
        """Its URDF."""
        leaf, joint = self.names
        root = self.root if self.root != leaf else "frame"
        base = f'<link name="map"/>{_fixed("map_to_frame", "map", root, "0.7 -0.4 0", "0 0 0.6")}' if self.base else ""
        ends = sorted((self.closed, self.closed + self._grows * 1.6))
        turn = -1.0 if self.turned_over else 1.0
        own = self.in_link * 0.5 * math.pi
        yaw = self.azimuth - turn * (own + self.axis * self.closed)
        place, yaw = self._in_frame(self.hinge, yaw)
        z = "3.141592653589793 0" if self.turned_over else "0 0"
        origin = f'<origin xyz="{_text(place)}" rpy="{z} {yaw:.9f}"/>'
        fixed_handle, handles = self._handles(own, turn)
        path.write_text(
            f"""<?xml version="1.0"?>
<robot name="door_{self.names[0]}">{base}<link name="{root}">{self._frame()}</link>
<joint name="{joint}" type="revolute">{origin}<parent link="{root}"/><child link="{leaf}"/><axis xyz="0 0 {self.axis:g}"/>
<limit lower="{ends[0]:.6f}" upper="{ends[1]:.6f}" velocity="3"/></joint>
<link name="{leaf}"><inertial><origin xyz="{_text(self._turned((0.5 * self.width, 0, 0.5 * self.height), own, turn))}"/>
<mass value="20"/><inertia ixx="6" ixy="0" ixz="0" iyy="6" iyz="0" izz="4"/></inertial>{self._shapes(own, turn)}{handles}</link>
{fixed_handle}{self._extras(root)}</robot>"""
        )
        return path

    def _in_frame(self, place: tuple[float, ...], yaw: float = 0.0) -> tuple[tuple[float, float, float], float]:
        """A place and a yaw of the world as the frame's link has them."""
        x, y, z = place
        if not self.base:
            return (x, y, z), yaw
        c, s = math.cos(0.6), math.sin(0.6)
        x, y = x - 0.7, y + 0.4
        return (c * x + s * y, c * y - s * x, z), yaw - 0.6

    def _frame(self) -> str:
        if not self.framed:
            return ""
        boxes = []
        for along in (-0.05, self.width + 0.055):
            c, s = math.cos(self.azimuth), math.sin(self.azimuth)
            at = self.hinge[0] + along * c, self.hinge[1] + along * s, 0.5 * self.height
            place, yaw = self._in_frame(at, self.azimuth)
            boxes.append(_box(place, (0.09, 0.12, self.height), yaw))
        return "".join(boxes)

    def _shapes(self, own: float, turn: float) -> str:
        w, h, t = self.width, self.height, 0.04
        boxes = {
            "slab": [((0.5 * w, 0.5 * h), (w, t, h))],
            "frame and panel": [
                ((0.05, 0.5 * h), (0.1, t, h)), ((w - 0.05, 0.5 * h), (0.1, t, h)),
                ((0.5 * w, 0.06), (w, t, 0.12)), ((0.5 * w, h - 0.06), (w, t, 0.12)), ((0.5 * w, 0.5 * h), (w - 0.2, 0.5 * t, h)),
            ],
            "two planks": [((0.25 * w, 0.5 * h), (0.5 * w, t, h)), ((0.75 * w, 0.5 * h), (0.5 * w, t, h))],
            "glazed": [((0.5 * w, 0.25 * h), (w, t, 0.5 * h)), ((0.5 * w, 0.75 * h), (w, 0.3 * t, 0.5 * h))],
        }[self.shape]  # fmt: skip
        return "".join(
            _box(self._turned((along, self.knuckle, up), own, turn), size, own) for (along, up), size in boxes
        )

    def _handles(self, own: float, turn: float) -> tuple[str, str]:
        """Links of their own, and shapes of the leaf."""
        places = [self._turned((self.width - 0.08, self.knuckle + side * 0.05, 1.0), own, turn) for side in (1.0, -1.0)]
        if self.handle == "box":
            return "", _box(places[0], (0.03, 0.06, 0.14), own)
        if self.handle == "both sides":
            return "", "".join(_box(place, (0.03, 0.06, 0.14), own) for place in places)
        if self.handle == "cylinder":
            shape = f'<origin xyz="{_text(places[1])}"/><geometry><cylinder radius="0.015" length="0.2"/></geometry>'
            return "", f"<collision>{shape}</collision>"
        if self.handle == "link":
            shape = '<collision><geometry><sphere radius="0.025"/></geometry></collision>'
            joint = _fixed("knob_joint", self.names[0], "knob", _text(places[0]), "0 0 0")
            return f'<link name="knob">{shape}</link>{joint}', ""
        return "", ""

    def _turned(self, place: tuple[float, float, float], own: float, turn: float) -> tuple[float, float, float]:
        """A place along the leaf, across it and up, as the leaf's link has it."""
        along, across, up = place
        c, s = math.cos(own), math.sin(own)
        across, up = turn * across, turn * up
        return c * along - s * across, s * along + c * across, up

    def _extras(self, root: str) -> str:
        if not self.extras:
            return ""
        return f"""<joint name="flap_joint" type="revolute"><origin xyz="3 3 1"/><parent link="{root}"/><child link="flap"/>
<axis xyz="0 1 0"/><limit lower="1" upper="-1" velocity="0"/></joint><link name="flap"><inertial><mass value="0.1"/>
<inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link>"""


def _text(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:.9f}" for value in values)


def _box(place: tuple[float, ...], size: tuple[float, ...], yaw: float) -> str:
    shape = f'<geometry><box size="{_text(size)}"/></geometry>'
    return f'<collision><origin xyz="{_text(place)}" rpy="0 0 {yaw:.9f}"/>{shape}</collision>'


def _fixed(name: str, parent: str, child: str, xyz: str, rpy: str) -> str:
    return (
        f'<joint name="{name}" type="fixed"><origin xyz="{xyz}" rpy="{rpy}"/><parent link="{parent}"/>'
        f'<child link="{child}"/></joint>'
    )


COUNT = 60
RIGHT_ANGLE = 7
"""A door that is shut at the end of a range that is a right angle, rounded."""


def test_doors_are_read_as_they_are(tmp_path: Path) -> None:
    """None is read wrongly without a question, and at most three are not read."""
    unreadable, wrong, asked = [], [], 0
    for number in range(COUNT):
        drawn = WrittenDoor.drawn(number)
        file = drawn.write(tmp_path / f"{number}.urdf")
        try:
            door = read_door(Scenario(door={"urdf": str(file), "leaf": drawn.names[0], "hinge": drawn.names[1]}))
        except DoormanError as error:
            unreadable.append(f"{number}: {error}")
            continue
        asked += door.closed_is_guessed
        touched = door.place_on_face(ContactSection())
        along = [math.cos(drawn.azimuth), math.sin(drawn.azimuth), 0.0]
        opens = drawn.opens * np.cross([0.0, 0.0, 1.0], along)
        faults = {
            "closed": abs(door.closed - drawn.closed) > 1e-3 and not door.closed_is_guessed,
            "width": abs(door.width - drawn.width) > 2e-3,
            "height": abs(door.height - drawn.height) > 2e-3,
            "contact": not (0.0 < touched[0] < door.width and 0.0 < touched[1] < door.height),
            "hinge": np.abs(door.hinge_position - drawn.hinge).max() > 2e-3,
            "along": not door.closed_is_guessed and float(door.along @ along) < 1.0 - 1e-6,
            "opens": not door.closed_is_guessed and float(door.into @ opens) < 1.0 - 1e-6,
        }
        if any(faults.values()):
            wrong.append(f"{number}: {[name for name, fault in faults.items() if fault]} of {drawn}")
    assert not wrong, "\n".join(wrong)
    assert len(unreadable) <= 3, "\n".join(unreadable)
    assert asked <= sum(not WrittenDoor.drawn(number).framed for number in range(COUNT))


def test_a_limit_that_is_rounded_keeps_no_door_shut(tmp_path: Path) -> None:
    """A joint whose zero is a right angle is shut at 1.570796."""
    drawn = WrittenDoor.drawn(RIGHT_ANGLE)
    file = drawn.write(tmp_path / "door.urdf")
    assert drawn.zero == "right angle"
    model = Model(Scenario(door={"urdf": str(file), "leaf": drawn.names[0], "hinge": drawn.names[1]}))
    (found,) = (each for each in setup_findings(model) if each.name == "hinge limits")
    assert found.ok, found.message
