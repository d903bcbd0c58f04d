"""Drawers of a catalogue: what the check says of each, against statics that this file works out by itself."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from urdf_variants import write_edited

from doorman import simulate
from doorman.feasibility import check
from doorman.model import Model
from doorman.resources import urdf_directory
from doorman.scenario import Scenario

DRAWER = urdf_directory() / "drawer.urdf"
PUSH = 3.0 * 9.81 * math.tan(0.25)
"""Of the shipped vehicle [N]."""
FOUND = 5.0 / 0.4
"""Force beyond what the scenario names that the shipped observers find [N]."""
LIMIT = 0.35
"""Of the shipped drawer [m]."""


@dataclass(frozen=True)
class CatalogueDrawer:
    """One entry."""

    mass: float = 6.0
    """[kg]."""
    friction: float = 2.0
    """[N]."""
    preload: float = 0.0
    """Of a self-closing slide, told to the planner [N]."""
    start: float = 0.0
    goal: float = 0.3
    """Openings [m]."""
    inclined: float = 0.0
    """Of the slide, downwards to the front [rad]."""
    latched: bool = False

    @property
    def possible(self) -> bool:
        """By statics; none is near the edge."""
        downhill = self.mass * 9.81 * math.sin(self.inclined)
        stays = downhill <= self.friction
        moves = self.friction + abs(self.preload - downhill) < min(PUSH, FOUND)
        return moves and stays and self.goal <= LIMIT and not self.latched

    def scenario(self, folder: Path) -> Scenario:
        """As a task."""
        turned = ('<origin xyz="0 0 1" rpy="0 0 0"/>', f'<origin xyz="0 0 1" rpy="0 {-self.inclined} 0"/>')
        heavy = ('<mass value="6"/>', f'<mass value="{self.mass}"/>')
        urdf = write_edited(folder / "drawer.urdf", DRAWER, turned, heavy)
        keys: dict[str, Any] = {
            "door.urdf": str(urdf), "door.friction": self.friction, "door.preload": self.preload,
            "door.latched": self.latched, "start.opening": self.start, "goal.opening": self.goal,
            "simulation.door_friction": None,
        }  # fmt: skip
        return Scenario.load("shipped:drawer", keys)


DRAWERS = (
    CatalogueDrawer(),
    CatalogueDrawer(friction=12.0),
    CatalogueDrawer(mass=2.0, friction=1.0, goal=0.2),
    CatalogueDrawer(mass=25.0, friction=3.0),
    CatalogueDrawer(start=0.3, goal=0.02),
    CatalogueDrawer(preload=2.5, friction=1.5),
    CatalogueDrawer(preload=14.0),
    CatalogueDrawer(goal=0.45),
    CatalogueDrawer(latched=True),
    CatalogueDrawer(inclined=0.02, friction=3.0),
    CatalogueDrawer(inclined=0.15, friction=3.0),
)


@pytest.mark.slow
@pytest.mark.parametrize("drawer", DRAWERS, ids=str)
def test_the_check_of_a_drawer_is_right(drawer: CatalogueDrawer, tmp_path: Path) -> None:
    report = check(drawer.scenario(tmp_path))
    assert report.possible is drawer.possible, [finding.words for finding in report.complaints]


@pytest.mark.slow
@pytest.mark.parametrize("drawer", [drawer for drawer in DRAWERS if drawer.possible], ids=str)
def test_a_possible_drawer_flies(drawer: CatalogueDrawer, tmp_path: Path) -> None:
    summary = simulate(Model(drawer.scenario(tmp_path)), seed=1).summary
    assert summary is not None and summary["outcome"] == "completed", summary
    assert abs(summary["final_error"]) < 0.01 and summary["collisions"] == 0
