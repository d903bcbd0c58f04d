"""Drawers of a catalogue: what the check says of each, and those that are possible in flight."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from completed_flights import completed
from urdf_variants import write_edited

from doorman.feasibility import check
from doorman.resources import urdf_directory
from doorman.scenario import Scenario

DRAWER = urdf_directory() / "drawer.urdf"
USUAL = {"friction": 2.0, "preload": 0.0, "latched": False}
"""Of the hinge: friction, and what shuts it, told to the planner [N]."""
DRAWERS: dict[str, tuple[bool, dict[str, Any]]] = {
    "usual": (True, {}),
    "stiff, with 12 N of 7.5 N": (False, {"friction": 12.0}),
    "light": (True, {"mass": 2.0, "friction": 1.0, "goal": 0.2}),
    "heavy": (True, {"mass": 25.0, "friction": 3.0}),
    "shut": (True, {"start": 0.3, "goal": 0.02}),
    "shuts itself": (True, {"preload": 2.5, "friction": 1.5}),
    "shuts with 14 N of 7.5 N": (False, {"preload": 14.0}),
    "beyond its 35 cm": (False, {"goal": 0.45}),
    "latched": (False, {"latched": True}),
    "downhill, held by friction": (True, {"inclined": 0.02, "friction": 3.0}),
    "runs downhill with 9 N": (False, {"inclined": 0.15, "friction": 3.0}),
}
"""Whether each is possible by statics, and what it is; none is near the edge."""


def task_of(name: str, folder: Path) -> Scenario:
    """A drawer of some mass [kg] on a slide inclined downwards to the front [rad]; openings in metres."""
    given = {"mass": 6.0, "inclined": 0.0, "start": 0.0, "goal": 0.3, **USUAL, **DRAWERS[name][1]}
    turned = ('<origin xyz="0 0 1" rpy="0 0 0"/>', f'<origin xyz="0 0 1" rpy="0 {-given["inclined"]} 0"/>')
    heavy = ('<mass value="6"/>', f'<mass value="{given["mass"]}"/>')
    urdf = write_edited(folder / "drawer.urdf", DRAWER, turned, heavy)
    keys = {f"door.{key}": given[key] for key in USUAL} | {f"{end}.opening": given[end] for end in ("start", "goal")}
    return Scenario.load("shipped:drawer", keys | {"door.urdf": str(urdf), "simulation.door_friction": None})


@pytest.mark.slow
@pytest.mark.parametrize("name", DRAWERS)
def test_a_drawer_flies_or_is_refused(name: str, tmp_path: Path) -> None:
    scenario = task_of(name, tmp_path)
    report = check(scenario)
    assert report.possible is DRAWERS[name][0], [finding.words for finding in report.complaints]
    if report.possible:
        completed(scenario, seed=1)
