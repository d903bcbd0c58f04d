"""Hatches of a catalogue: what the check says of each, against statics of the leaf's weight."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import pytest
from urdf_variants import write_edited

from doorman import simulate
from doorman.feasibility import check
from doorman.model import Model
from doorman.resources import urdf_directory
from doorman.scenario import Scenario

HATCH = urdf_directory() / "hatch.urdf"
PUSH = 3.0 * 9.81 * math.tan(0.25)
"""Of the shipped vehicle, to the side [N]."""
REACH = math.hypot(0.62, 0.04)
"""Of the hatch's handle from its hinge [m]."""


@dataclass(frozen=True)
class CatalogueHatch:
    """A flap on a hinge at its upper edge, lifted by its handle."""

    mass: float
    """[kg]."""
    opening: float
    """[rad]."""
    friction: float = 0.3
    """[N m]."""

    @property
    def torque(self) -> float:
        """Of its weight at the goal, where it is largest, and of friction [N m]."""
        arm = 0.35 * math.sin(self.opening) - 0.008 * math.cos(self.opening)
        return self.mass * 9.81 * arm + self.friction

    @property
    def possible(self) -> bool:
        """By statics: the vehicle lifts it along its way, with thrust upwards and a push to the side."""
        return self.torque < PUSH * REACH

    def scenario(self, folder: Path) -> Scenario:
        """As a task."""
        moments = {"ixx": 0.113, "iyy": 0.0490256, "izz": 0.0640256}
        heavier = ((f'{key}="{value}"', f'{key}="{value * self.mass / 1.2}"') for key, value in moments.items())
        mass = ('<mass value="1.2"/>', f'<mass value="{self.mass}"/>')
        urdf = write_edited(folder / "hatch.urdf", HATCH, mass, *heavier)
        keys = {"door.urdf": str(urdf), "goal.opening": self.opening, "simulation.door_friction": self.friction}
        return Scenario.load("shipped:hatch", keys)


HATCHES = (
    CatalogueHatch(0.8, 0.6),
    CatalogueHatch(1.2, 0.4),
    CatalogueHatch(1.2, 0.7, friction=1.0),
    CatalogueHatch(6.0, 0.7),
    CatalogueHatch(4.0, 1.0),
)


@pytest.mark.slow
@pytest.mark.parametrize("hatch", HATCHES, ids=str)
def test_the_check_of_a_hatch_is_right(hatch: CatalogueHatch, tmp_path: Path) -> None:
    report = check(hatch.scenario(tmp_path))
    words = [finding.words for finding in report.complaints]
    assert report.possible is hatch.possible, words
    assert hatch.possible or any("N m" in each for each in words), words


@pytest.mark.slow
@pytest.mark.parametrize("hatch", [hatch for hatch in HATCHES if hatch.possible], ids=str)
def test_a_possible_hatch_is_lifted(hatch: CatalogueHatch, tmp_path: Path) -> None:
    summary = simulate(Model(hatch.scenario(tmp_path)), seed=1).summary
    assert summary is not None and summary["outcome"] == "completed", summary
    assert abs(summary["final_error"]) < 1.5 and summary["collisions"] == 0
