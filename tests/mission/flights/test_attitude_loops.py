"""Flights behind attitude loops that nobody told them of: measured in hover, flown by what was measured, or refused there."""

from __future__ import annotations

from typing import Any

import pytest
from completed_flights import completed

from doorman import Scenario, simulate


def loop(lag: float, dead: float, **more: float) -> dict[str, float]:
    """Keys of the simulated loop [s]."""
    return {
        f"simulation.{name}": value for name, value in {"attitude_lag": lag, "attitude_dead_time": dead, **more}.items()
    }


@pytest.mark.parametrize(
    ("lag", "dead", "words"),
    [
        (0.4, 0.05, ("behind its commands", "250 ms", "MC_ROLL_P", "ATC_ANG_RLL_P")),
        (0.2, 0.25, ("dead time", "350 ms", "line to the autopilot")),
    ],
)
def test_a_loop_that_was_never_tested_is_refused_in_hover(lag: float, dead: float, words: tuple[str, ...]) -> None:
    summary: Any = simulate(Scenario.load("shipped:push", loop(lag, dead)), seed=1).summary
    assert summary["outcome"] == "given up" and summary["attempts"] == 1
    assert all(word in summary["reason"] for word in words), summary["reason"]
    assert summary["contact_fraction"] == summary["collisions"] == 0


@pytest.mark.slow
@pytest.mark.parametrize(("source", "lag", "dead"), [("push", 0.05, 0.07), ("push", 0.22, 0.08), ("paper", 0.1, 0.06)])
def test_loops_of_autopilots_open_the_door(source: str, lag: float, dead: float) -> None:
    completed(source, loop(lag, dead), 1, final_error=2.5)


@pytest.mark.parametrize("source", ["cabinet", pytest.param("close", marks=pytest.mark.slow)])
def test_a_grip_plans_with_the_lag_that_hover_has_measured(source: str) -> None:
    """A light leaf swings about its goal for as long as it may, if the plan knows neither lag nor dead time."""
    completed(source, loop(0.16, 0.06), 1, time_to_open_s=10.0, max_pull_force_n=8.0)


@pytest.mark.slow
@pytest.mark.parametrize("lag", [0.04, 0.06])
def test_a_quick_loop_does_not_chatter_on_the_leaf(lag: float) -> None:
    """As quick as ArduPilot's with its feed-forward: plans answer the noise of the estimated force at once."""
    quick = loop(lag, 0.075, motor_time_constant=0.01)
    _, recording = completed(
        "push", quick, force=True
    )  # the check doubts that the rotors bear feedback as quick as this
    assert list(recording["mission"]["state"]).count("recover") <= 2
