"""Levers and valves in flight, and latched doors that are opened by them."""

from __future__ import annotations

import numpy as np
import pytest

from doorman import simulate
from doorman.model import Model
from doorman.scenario import Scenario


@pytest.mark.slow
def test_a_latched_door_is_opened_by_its_lever() -> None:
    recording = simulate(Model("lever_pull"), force=True)
    summary = recording.summary
    assert summary["opened"] and summary["collisions"] == 0
    assert [step["joint"] for step in summary["steps"]] == ["lever", "hinge"]
    lowered = recording["truth"]["tip_force"][:, 2]
    assert float(np.median(lowered[: len(lowered) // 4])) < -0.5, "the lever is held down while the leaf moves"


@pytest.mark.slow
def test_a_lever_that_is_not_turned_far_enough_ends_honestly() -> None:
    """The true latch opens later than the lever is turned: the leaf does not move, and nobody says that it did."""
    scenario = Scenario.load("lever_pull", {"door.latch.opens_at": 0.8})
    summary = simulate(Model(scenario), force=True).summary
    assert not summary["opened"] and summary["collisions"] == 0
    assert summary["reason"]
    assert abs(summary["final_door_angle_deg"] - 90.0) < 2.0
