"""Levers and valves in flight, and latched doors that are opened by them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman import simulate
from doorman.model import Model
from doorman.scenario import FirstSection, Scenario

SHIPPED = Scenario.load("lever_pull").first[0]


def with_lever(**true: float) -> FirstSection:
    """The shipped first step, with another lever in the plant."""
    return SHIPPED.model_copy(update={"true": SHIPPED.true.model_copy(update=true)})


@pytest.mark.slow
def test_a_valve_is_opened() -> None:
    summary = simulate("knob_valve").summary
    assert summary["outcome"] == "completed" and summary["collisions"] == 0


@pytest.mark.slow
@pytest.mark.parametrize("task", ["lever_pull", "lever_push"])
def test_a_latched_door_is_opened_by_its_lever(task: str) -> None:
    recording = simulate(task)
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


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_levers_that_are_not_as_told(seed: int) -> None:
    """Spring and friction are up to 40 % more or less, and the poses are noisy."""
    share = 1.0 + 0.4 * math.cos(math.pi * seed / 3)
    first = with_lever(preload=0.2 * share, stiffness=0.2 * share, friction=0.08 / share)
    noise = {"simulation.noise.position": 1e-3, "simulation.noise.attitude": math.radians(0.2)}
    scenario = Scenario.load("lever_pull", noise).model_copy(update={"first": (first,)})
    summary = simulate(Model(scenario), seed=seed).summary
    assert summary["opened"] and summary["collisions"] == 0
