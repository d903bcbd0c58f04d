"""Batches: the flights of `simulate`, in processes of their own, in the order of their seeds."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import doorman
from doorman import Model, Recording, Scenario, simulate, simulate_batch
from doorman.campaign.flights import flight_process
from doorman.exceptions import DoormanError, InfeasibleError

CLOCK = ("planner_ms", "planner_rate_hz", "deadline_misses", "realtime_factor")
"""Figures of a summary that the machine decides."""


@pytest.fixture(scope="module")
def noisy() -> Scenario:
    return Scenario.load("paper", {"mission.start": "contact", "simulation.noise.position": 0.001})


def without_clock(summary: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in summary.items() if key not in CLOCK}


def test_flights_are_those_of_simulate_in_the_order_of_the_seeds(noisy: Scenario, tmp_path: Path) -> None:
    seeds, heard = [7, 2, 2**31], []
    flights = simulate_batch(
        noisy, seeds, 0.3, workers=2, folder=tmp_path / "new", on_flight=heard.append, force=True
    )  # fmt: skip
    assert [flight.seed for flight in flights] == seeds
    assert sorted(flight.seed for flight in heard) == sorted(seeds)
    angles = set()
    for flight in flights:
        alone = simulate(noisy, 0.3, flight.seed, force=True)
        assert flight.error == "" and flight.summary is not None and flight.recording is not None
        assert without_clock(flight.summary) == without_clock(alone.summary or {})
        assert 0.0 < flight.wall_time < 60.0
        recorded = Recording.load(flight.recording)
        np.testing.assert_array_equal(recorded["truth"]["door_angle"], alone["truth"]["door_angle"])
        assert recorded.complete and recorded.header["seed"] == flight.seed
        angles.add(float(alone["truth"]["door_angle"][-1]))
    assert {path.name for path in (tmp_path / "new").iterdir()} == {f"seed-{seed}.mcap" for seed in seeds}
    assert len(angles) == 3, "every seed is another flight"


def test_no_seeds_are_no_flights(noisy: Scenario) -> None:
    assert simulate_batch(noisy, [], force=True) == []


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"seeds": [1, 2, 1]}, "seeds"),
        ({"seeds": [0, -1]}, "seeds[1]"),
        ({"seeds": [1.0]}, "seeds[0]"),
        ({"duration": 0.0}, "duration"),
        ({"duration": math.inf}, "duration"),
        ({"workers": 0}, "workers"),
        ({"workers": True}, "workers"),
    ],
)
def test_what_cannot_be_flown_is_said_before_any_process(
    noisy: Scenario, given: dict[str, Any], field: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(flight_process, "FlightProcess", None)
    with pytest.raises(DoormanError) as error:
        simulate_batch(noisy, **{"seeds": [1], **given})
    assert error.value.field == field


def test_a_scenario_that_the_check_refuses_is_not_flown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flight_process, "FlightProcess", None)
    with pytest.raises(InfeasibleError):
        simulate_batch(Scenario.load("paper", {"planner.margin": 0.2}), [1])


class _Dying:
    """A flight process that dies at first, hangs for one seed, and counts how often it was let go."""

    made: list[_Dying] = []

    def __init__(self) -> None:
        self.made.append(self)
        self.asked, self.closed = 0, False

    def fly(self, order: dict[str, Any], files: Any, time_out: float) -> dict[str, Any]:
        self.asked += 1
        if order["seed"] == 13 or self.asked == 1:
            return batch_lost()
        return {"summary": {"seed": order["seed"]}, "error": None, "wall_time_s": 1.0}

    def close(self) -> None:
        self.closed = True


def batch_lost() -> dict[str, Any]:
    return {"summary": None, "error": "the process died", "wall_time_s": None, "lost": True}


def test_a_process_that_dies_costs_its_own_flight_after_three_attempts(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    _Dying.made.clear()
    monkeypatch.setattr(flight_process, "FlightProcess", _Dying)
    flights = simulate_batch(model, [5, 13, 6], workers=1, force=True)
    assert [flight.summary for flight in flights] == [{"seed": 5}, None, {"seed": 6}]
    assert [flight.error for flight in flights] == ["", "the process died", ""]
    assert math.isnan(flights[1].wall_time) and flights[1].recording is None
    (process,) = _Dying.made
    assert process.closed and process.asked == 2 + 3 + 1


def test_what_the_caller_raises_ends_the_batch(model: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    _Dying.made.clear()
    monkeypatch.setattr(flight_process, "FlightProcess", _Dying)

    def stop(flight: doorman.campaign.BatchFlight) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate_batch(model, range(100), workers=1, on_flight=stop, force=True)
    assert all(process.closed for process in _Dying.made)
    assert sum(process.asked for process in _Dying.made) < 100
