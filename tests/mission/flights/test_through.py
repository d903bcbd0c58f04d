"""Missions that fly through the door that they have opened."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hands import flown, phases
from urdf_variants import write_door

from doorman import Recording, Scenario, simulate
from doorman.mission import Mission
from doorman.mission.phases.free_flight.through import Through
from doorman.summary import verdict

AJAR: dict[str, Any] = {
    "contact__kind": "grip",
    "mission__start": "contact",
    "planner__model": "quasi_static",
    "start__opening": 1.3,
    "door__friction": 1.0,
    "simulation__door_friction": 1.0,
}
"""Nearly open from the start: the flight is short."""


def flown_through(abort_at: float) -> tuple[Recording, Mission]:
    """A flight that is aborted once the vehicle has come so far into the doorway [m]."""

    def watch(mission: Mission, now: float, angle: float) -> None:
        phase, passage = mission._sequence._now, mission._sequence.attempt.passage
        if isinstance(phase, Through) and passage is not None and passage.into(phase.glide.position) > abort_at:
            mission.abort("asked to")

    return flown(scenario="through", on_progress=watch, **AJAR)


@pytest.mark.parametrize("abort_at, ends_behind", [pytest.param(-0.9, False, marks=pytest.mark.slow), (0.1, True)])
def test_an_abort_ends_on_the_nearer_side(abort_at: float, ends_behind: bool) -> None:
    recording, mission = flown_through(abort_at)
    assert phases(recording)[-3:] == ["through", "done", "end"]
    truth, passage = recording["truth"], mission._sequence.attempt.passage
    assert passage is not None and int(truth["collisions"].sum()) == 0
    last = truth["position"][-1]
    assert passage.outside(last) is not ends_behind
    if ends_behind:
        assert passage.into(last) == pytest.approx(passage.into(passage.exit), abs=0.15)


@pytest.mark.slow
def test_a_door_that_would_not_stay_is_not_flown_through() -> None:
    recording, mission = flown(scenario="through", simulation__door_preload=1.2)
    assert "hold" in phases(recording) and "through" not in phases(recording)
    opened, reason = mission.outcome
    assert not opened and "did not stay" in reason


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_the_shipped_scenario_with_noise(seed: int) -> None:
    recording = simulate(Scenario.load("shipped:through"), seed=seed)
    summary = recording.summary
    assert summary is not None and summary["went_through"] and summary["collisions"] == 0, summary
    assert summary["min_clearance_m"] > 0.0 and abs(summary["final_error"]) < 1.5
    assert verdict(summary)[0] and "behind it" in verdict(summary)[1]


@pytest.mark.slow
def test_a_pulled_door_is_flown_through(tmp_path: Path) -> None:
    pulled: dict[str, Any] = {
        "door.urdf": str(write_door(tmp_path / "door.urdf", width=1.25, mass=20.0)), "contact.side": "pull",
        "contact.kind": "grip",
        "contact.distance_from_hinge": 1.1, "contact.height": 0.9, "goal.opening": 1.45, "mission.then": "through",
    }  # fmt: skip
    summary = simulate(Scenario.load("shipped:through", pulled), seed=1).summary
    assert summary is not None and summary["went_through"] and summary["collisions"] == 0, summary
