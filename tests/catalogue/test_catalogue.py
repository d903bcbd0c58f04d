"""Doors of a catalogue: what the check says of each, against geometry and statics that this file works out by itself.

Sizes are those of room, entrance and cupboard doors: 0.62 to 1.25 m wide, 8 to 60 kg. A door is possible here where the disc
passes, or need not, where nothing latches it, and where a tilted vehicle's push turns it; none is near the edge of that.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from completed_flights import completed
from urdf_variants import write_door, write_mirrored

from doorman.feasibility import check
from doorman.scenario import Scenario

DISC, MARGIN = 0.40, 0.03
"""Radius of the shipped vehicle's rotor disc, and the planner's margin [m]."""
WEIGHT, TILT = 3.0 * 9.81, 0.25
"""Of the shipped vehicle [N], and the most that the controller tilts it [rad]."""
FOUND = 2.0
"""Torque beyond what the scenario names that the shipped observers find [N m]."""
LEAF = {0.62: 8.0, 0.73: 12.0, 0.82: 18.0, 0.90: 24.0, 1.00: 30.0, 1.10: 32.0, 1.20: 36.0, 1.25: 40.0}
"""Masses of leaves by width [m], [kg]."""


@dataclass(frozen=True)
class CatalogueDoor:
    """One entry."""

    width: float
    """[m]."""
    left: bool = False
    """Whether the hinge is on the left of somebody who pushes it."""
    side: str = "pull"
    kind: str = "grip"
    opening: float = 1.1
    """[rad]."""
    mass: float | None = None
    """[kg]."""
    friction: float = 0.4
    """[N m]."""
    preload: float = 0.0
    """Of a closer, told to the planner [N m]."""
    latched: bool = False

    @property
    def distance(self) -> float:
        """Of the contact from the hinge: near the latch where it is pulled, mid-way where a disc must pass [m]."""
        return self.width - 0.1 if self.side == "pull" else 0.5 * self.width

    @property
    def possible(self) -> bool:
        """By geometry and statics."""
        passes = self.side == "pull" or self.width > 2.0 * (DISC + MARGIN)
        can = self.kind == "grip" or self.side == "push"
        push = WEIGHT * math.tan(TILT) * self.distance
        turns = self.friction + self.preload < push and self.friction < FOUND
        return passes and can and turns and not self.latched

    def scenario(self, folder: Path) -> Scenario:
        """As a task."""
        door = write_door(folder / "door.urdf", width=self.width, height=2.0, mass=self.mass or LEAF[self.width])
        urdf = write_mirrored(folder / "left.urdf", door) if self.left else door
        keys: dict[str, Any] = {
            "door.urdf": str(urdf), "door.latched": self.latched, "door.preload": self.preload,
            "door.friction": self.friction, "contact.distance_from_hinge": self.distance, "contact.height": 0.9,
            "contact.kind": self.kind, "contact.side": self.side, "goal.door_angle": None, "goal.opening": self.opening,
            "start.door_angle": None, "simulation.door_friction": None,
        }  # fmt: skip
        if self.kind == "push":
            keys["planner.model"] = "whole_body"
        return Scenario.load("shipped:paper", keys)


def catalogue() -> Iterator[CatalogueDoor]:
    """All entries."""
    for left in (False, True):
        for width in LEAF:
            yield CatalogueDoor(width, left, "pull")
            if width <= 0.82 or width >= 1.2:
                yield CatalogueDoor(width, left, "push")
        yield CatalogueDoor(1.2, left, "push", "push", opening=1.2)
        yield CatalogueDoor(1.0, left, "pull", "push")
        yield CatalogueDoor(0.9, left, latched=True)
        yield CatalogueDoor(1.2, left, "push", latched=True)
        yield CatalogueDoor(0.9, left, preload=2.0)
        yield CatalogueDoor(0.9, left, preload=12.0)
        yield CatalogueDoor(1.0, left, friction=8.0)
        yield CatalogueDoor(1.25, left, mass=60.0)


DOORS = list(catalogue())
FEW = {0, 1}
"""That the short run looks at: one of each verdict."""


@pytest.mark.parametrize(
    "door", [pytest.param(door, marks=[] if k in FEW else pytest.mark.slow) for k, door in enumerate(DOORS)], ids=str
)
def test_the_check_is_right(door: CatalogueDoor, tmp_path: Path) -> None:
    report = check(door.scenario(tmp_path))
    assert report.possible is door.possible, [finding.words for finding in report.complaints]


@pytest.mark.slow
@pytest.mark.parametrize("door", [door for door in DOORS if door.possible and door.preload == 0.0][::2], ids=str)
def test_what_is_possible_flies(door: CatalogueDoor, tmp_path: Path) -> None:
    completed(door.scenario(tmp_path), seed=1)
