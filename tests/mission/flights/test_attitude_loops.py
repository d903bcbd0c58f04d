"""Flights behind attitude loops that nobody told them of: measured in hover, flown by what was measured, or refused there."""

from __future__ import annotations

from typing import Any

import pytest

from doorman import Scenario, simulate


def flown(scenario: str, lag: float, dead: float, seed: int = 1, **settings: Any) -> dict[str, Any]:
    loop = {"simulation.attitude_lag": lag, "simulation.attitude_dead_time": dead}
    keys = {key.replace("__", "."): value for key, value in settings.items()}
    summary = simulate(Scenario.load(f"shipped:{scenario}", {**loop, **keys}), seed=seed).summary
    assert summary is not None and summary["collisions"] == 0
    return summary


@pytest.mark.parametrize(("lag", "dead", "words"), [(0.4, 0.05, ("behind its commands", "250 ms", "MC_ROLL_P", "ATC_ANG_RLL_P")),
                                                    (0.2, 0.25, ("dead time", "350 ms", "line to the autopilot"))])  # fmt: skip
def test_a_loop_that_was_never_tested_is_refused_in_hover(lag: float, dead: float, words: tuple[str, ...]) -> None:
    summary = flown("push", lag, dead)
    assert summary["outcome"] == "given up" and summary["attempts"] == 1
    assert all(word in summary["reason"] for word in words), summary["reason"]
    assert summary["contact_fraction"] == 0.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scenario", "lag", "dead"), [("push", 0.05, 0.07), ("push", 0.22, 0.08), ("paper", 0.1, 0.06)]
)
def test_loops_of_autopilots_open_the_door(scenario: str, lag: float, dead: float) -> None:
    summary = flown(scenario, lag, dead)
    assert summary["outcome"] == "completed" and abs(summary["final_error"]) < 2.5


@pytest.mark.parametrize(
    ("scenario", "lag", "dead"),
    [("cabinet", 0.16, 0.06), pytest.param("close", 0.16, 0.06, marks=pytest.mark.slow)],
)  # fmt: skip
def test_a_grip_plans_with_the_lag_that_hover_has_measured(scenario: str, lag: float, dead: float) -> None:
    """A light leaf swings about its goal for as long as it may, if the plan knows neither lag nor dead time."""
    summary = flown(scenario, lag, dead)
    assert summary["outcome"] == "completed" and abs(summary["final_error"]) < 1.5
    assert summary["time_to_open_s"] < 10.0 and summary["max_pull_force_n"] < 8.0


@pytest.mark.slow
@pytest.mark.parametrize("lag", [0.04, 0.06])
def test_a_quick_loop_does_not_chatter_on_the_leaf(lag: float) -> None:
    """As quick as ArduPilot's with its feed-forward: plans answer the noise of the estimated force at once."""
    loop = {"attitude_lag": lag, "attitude_dead_time": 0.075, "motor_time_constant": 0.01}
    scenario = Scenario.load("shipped:push", {f"simulation.{key}": value for key, value in loop.items()})
    recording = simulate(scenario, force=True)  # the check doubts that the rotors bear feedback as quick as this
    summary = recording.summary
    assert summary is not None and summary["outcome"] == "completed" and summary["collisions"] == 0
    assert abs(summary["final_error"]) < 1.5
    assert list(recording["mission"]["state"]).count("recover") <= 2
