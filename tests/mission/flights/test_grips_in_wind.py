"""Steady wind from the side, which comes to blow along the leaf's normal as the door opens."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman import Recording, simulate
from doorman.scenario import Scenario

WIND = {"simulation.gust.vehicle": 2.0, "simulation.gust.variation": 0.0}


def opens(task: str, direction: float) -> Recording:
    """A flight in 2 N of wind that opens the door at the first attempt."""
    recording = simulate(Scenario.load(task, {**WIND, "simulation.gust.direction": direction}), seed=0)
    summary = recording.summary
    assert summary is not None and summary["outcome"] == "completed" and summary["collisions"] == 0, summary
    assert abs(summary["final_error"]) < 1.0 and summary["contact_fraction"] >= 0.98
    assert list(recording["mission"]["state"]).count("open") == 1
    return recording


@pytest.mark.parametrize(
    "direction", [math.pi / 2, pytest.param(-math.pi / 2, marks=pytest.mark.slow)], ids=["against", "along"]
)
def test_a_grip_opens_the_door_in_wind_against_its_swing_and_along_it(direction: float) -> None:
    opens("paper", direction)


@pytest.mark.slow
@pytest.mark.parametrize("task", ["paper_tilted", "push_tilted"])
@pytest.mark.parametrize("direction", [math.pi / 2, -math.pi / 2], ids=["against", "along"])
def test_a_level_body_holds_its_place_in_side_wind(task: str, direction: float) -> None:
    """Within 2 cm before the door, once the approach has begun."""
    recording = opens(task, direction)
    mission, truth, setpoint = recording["mission"], recording["truth"], recording["setpoint"]
    began, ended = (mission.time[list(mission["state"]).index(phase)] for phase in ("approach", "touch"))
    flies = (truth.time > began) & (truth.time < ended)
    assert np.linalg.norm((truth["position"] - setpoint["position"])[flies], axis=1).max() < 0.02
    assert np.degrees(np.abs(truth["attitude"][:, :2])).max() < 3.2
