"""Levers and valves in flight, and latched doors that are opened by them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from doorman import simulate
from doorman.model import Model
from doorman.scenario import Scenario

TURNED_AROUND = 0.4
"""Share by which what a joint resists with may be otherwise than its scenario says."""
JAMMED = 30.0
"""Friction against which no vehicle turns a lever [N m]."""


def drawn(name: str, seed: int) -> Scenario:
    """A shipped task whose true joints resist by up to 40 % more or less than they do there; nobody tells the vehicle."""
    rng, plain = np.random.default_rng([seed, 720]), Scenario.load(name)

    def other(value: float | None) -> float:
        assert value is not None
        return value * float(1.0 + rng.uniform(-TURNED_AROUND, TURNED_AROUND))

    true = plain.simulation
    keys: dict[str, Any] = {
        "simulation.door_friction": other(true.door_friction), "simulation.door_damping": other(true.door_damping),
    }  # fmt: skip
    if plain.first:
        (step,) = plain.first
        keys["first"] = [with_true(
            step, friction=other(step.true.friction), damping=other(step.true.damping),
            preload=other(step.true.preload), stiffness=other(step.door.stiffness),
        )]  # fmt: skip
    return Scenario.load(name, keys)


def with_true(step: Any, **values: float) -> dict[str, Any]:
    """A step whose true joint has other values."""
    written: dict[str, Any] = step.model_dump(exclude_unset=True)
    return written | {"true": written.get("true", {}) | values}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lever_pull", "lever_push"])
@pytest.mark.parametrize("seed", [None, 0, 1])
def test_a_latched_door_is_opened_by_its_lever(name: str, seed: int | None) -> None:
    model = Model(name if seed is None else drawn(name, seed))
    recording = simulate(model, seed=seed or 0)
    summary = recording.summary
    assert summary["opened"] and summary["collisions"] == 0
    assert [(step["joint"], step["outcome"]) for step in summary["steps"]] == [
        ("lever", "completed"),
        ("hinge", "completed"),
    ]
    lowered = recording["truth"]["tip_force"][:, 2]
    assert float(np.median(lowered[: len(lowered) // 4])) < -0.5, "the lever is held down while the leaf moves"


@pytest.mark.slow
@pytest.mark.parametrize("seed", [None, 0, 1])
def test_a_valve_is_turned_in_the_plane_of_its_wall(seed: int | None) -> None:
    model = Model("knob_valve" if seed is None else drawn("knob_valve", seed))
    summary = simulate(model, seed=seed or 0).summary
    assert summary["opened"] and summary["outcome"] == "completed" and summary["collisions"] == 0


@pytest.mark.slow
def test_a_lever_that_is_not_turned_far_enough_ends_honestly() -> None:
    """The true latch opens beyond the lever's range: the leaf does not move, and nobody says that it did."""
    scenario = Scenario.load("lever_pull", {"door.latch.opens_at": 1.2})
    summary = simulate(Model(scenario), force=True).summary
    assert not summary["opened"] and summary["collisions"] == 0
    assert summary["reason"]
    assert abs(summary["final_door_angle_deg"] - 90.0) < 2.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lever_push", "knob_valve"])
def test_a_handle_that_does_not_turn_ends_honestly(name: str) -> None:
    plain = Scenario.load(name)
    jammed: dict[str, Any] = {"simulation.door_friction": JAMMED}
    if plain.first:
        jammed = {"first": [with_true(step, friction=JAMMED) for step in plain.first]}
    summary = simulate(Model(Scenario.load(name, jammed)), force=True).summary
    assert not summary["opened"] and summary["outcome"] == "given up"
    assert summary["collisions"] == 0
    assert "does not move" in summary["reason"], summary["reason"]
