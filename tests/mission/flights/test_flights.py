"""Whole flights on the simulator: the numbers that doorman promises, and what happens when something goes wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from urdf_variants import write_arm, write_door

from doorman import Model, Planner, Scenario, simulate
from doorman.exceptions import DoormanError
from doorman.recording import Recorder, Recording
from doorman.summary import summarize, verdict


@pytest.fixture(scope="module")
def model() -> Model:
    """The paper's task as the paper flew it, from the touch on."""
    return Model(Scenario.load("paper", {"mission.start": "contact"}))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the flights below are recorded."""
    return tmp_path_factory.mktemp("flights")


@pytest.fixture(scope="module")
def paper(folder: Path) -> Recording:
    """The paper's task from hover to hover."""
    return simulate(Scenario.load("paper"), seed=0, path=folder / "paper.mcap")


@pytest.fixture(scope="module")
def pushed(folder: Path) -> Recording:
    """The same with a tip that can only push, on a hinge that the planner does not know."""
    return simulate(Scenario.load("push"), seed=0, path=folder / "pushed.mcap")


def test_the_papers_door_is_opened(paper: Recording) -> None:
    summary = paper.summary
    assert summary is not None
    assert summary["opened"] and verdict(summary)[0]
    assert abs(summary["final_door_angle_deg"] - 20.0) < 1.0
    assert summary["time_to_open_s"] < 8.0
    assert summary["max_constraint_violation_m"] <= 0.01
    assert summary["min_clearance_m"] > 0.0
    assert summary["collisions"] == 0
    assert summary["contact_fraction"] >= 0.98 and summary["contact_fraction_after_1s"] == 1.0  # it bounces once
    assert summary["door_angle_estimate_error_deg_max"] < 1.0
    assert summary["planner_rate_hz"] == pytest.approx(100.0, rel=0.01)
    assert (summary["outcome"], summary["reason"]) == ("completed", "")


def test_a_minute_is_recorded_in_twenty_megabytes(paper: Recording, folder: Path) -> None:
    assert (folder / "paper.mcap").stat().st_size < 20e6 * paper["truth"].time[-1] / 60.0


PHASES = ["hover", "approach", "touch", "open", "release", "retreat", "done", "end"]


@pytest.mark.parametrize("kind", ["paper", "pushed"])
def test_the_mission_goes_from_hover_to_hover(kind: str, request: pytest.FixtureRequest) -> None:
    recording = request.getfixturevalue(kind)
    mission, truth, scenario = recording["mission"], recording["truth"], Scenario.load("paper")
    assert mission["state"].tolist() == PHASES
    assert not any(mission["message"][:-1])
    for place in (0, -1):
        out_of_the_doorway = -0.4 - 0.9 * scenario.mission.hover_distance
        assert truth["position"][place, 0] < out_of_the_doorway
        assert np.linalg.norm(truth["velocity"][place]) < 0.3
    closing = truth["velocity"][np.flatnonzero(truth["touching"])[0], 0]
    assert 0.0 < closing < 0.1, "it touches gently"


def test_a_tip_that_can_only_push_opens_a_door_that_it_does_not_know(pushed: Recording) -> None:
    summary = pushed.summary
    assert summary is not None
    assert verdict(summary)[0], verdict(summary)[1]
    assert abs(summary["final_door_angle_deg"] - 20.0) < 1.0
    assert summary["contact_fraction"] >= 0.96 and summary["contact_fraction_after_1s"] >= 0.98
    assert summary["planned_normal_force_n_min"] >= 0.0
    assert summary["door_angle_estimate_error_deg_max"] <= 1.0
    assert summary["collisions"] == 0 and summary["max_pull_force_n"] == 0.0
    assert summary["hover_to_goal_s"] < 25.0
    found, true = summary["estimates"]["torque"]["value"], summary["estimates"]["torque"]["true"]
    assert abs(found - true) <= max(0.25, 0.25 * true)


def test_the_tips_force_is_estimated(pushed: Recording) -> None:
    truth, estimate = pushed["truth"], pushed["estimate"]
    moving = (truth.time > 10.0) & (truth.time < 20.0)
    average, found = (  # the estimate lags by a tenth of a second
        np.convolve(force, np.full(125, 1 / 125), mode="same")
        for force in (truth["tip_normal_force"], estimate["normal_force"])
    )
    assert np.abs(average - found)[moving].mean() < 0.2


def test_every_plan_that_was_flown_keeps_the_constraints(paper: Recording, model: Model) -> None:
    plan, margin = paper["plan"], model.scenario.planner.margin
    for k in range(0, len(plan.time), 40):
        assert model.constraints_along(plan["states"][k][1:]).max() <= -margin + 1e-6


def test_another_door_and_arm(tmp_path: Path) -> None:
    door = write_door(tmp_path / "door.urdf", width=1.15, mass=18.0, damping=0.6, friction=0.6)
    arm = write_arm(tmp_path / "arm.urdf", rod=0.24)
    overrides = {"vehicle.urdf": str(arm), "door.urdf": str(door), "contact.distance_from_hinge": 0.6,
                 "mission.start": "contact"}  # fmt: skip
    summary = simulate(Scenario.load("paper", overrides), duration=12.0).summary
    assert summary is not None
    assert abs(summary["final_door_angle_deg"] - 20.0) < 1.5
    assert summary["collisions"] == 0 and summary["min_clearance_m"] > 0.0
    assert summary["max_constraint_violation_m"] <= 0.01


@pytest.mark.parametrize(
    "hinge",
    [{"door_mass": 20.0}, pytest.param({"door_friction": 2.0, "door_damping": 2.0}, marks=pytest.mark.slow)],
    ids=["heavy", "stiff"],
)
def test_a_grip_stops_doors_that_it_does_not_know_at_the_goal(hinge: dict[str, float]) -> None:
    overrides = {f"simulation.{name}": value for name, value in hinge.items()}
    summary = simulate(Scenario.load("paper", {"mission.start": "contact", **overrides}), duration=14.0).summary
    assert summary is not None
    assert abs(summary["final_door_angle_deg"] - 20.0) < 1.0
    assert summary["collisions"] == 0 and summary["max_constraint_violation_m"] <= 0.01
    assert summary["time_to_open_s"] < (8.0 if "door_mass" in hinge else 10.0)
    inertia = summary["estimates"]["inertia"]
    assert abs(inertia["value"] - inertia["true"]) < 0.25 * inertia["true"]


def test_interrupted_flight_keeps_what_was_flown(model: Model, tmp_path: Path) -> None:
    def interrupt(time: float, _: float) -> None:
        if time > 0.3:
            raise KeyboardInterrupt

    recording = simulate(model, duration=5.0, path=tmp_path / "run.mcap", on_progress=interrupt)
    assert 0.3 < recording["truth"].time[-1] < 0.4
    assert recording["mission"]["message"][-1] == "interrupted"
    assert recording.summary is not None and not recording.summary["opened"]
    assert len(Recording.load(tmp_path / "run.mcap")["truth"].time) == len(recording["truth"].time)


def test_a_planner_of_another_scenario_is_refused(model: Model) -> None:
    other = Planner(Scenario.load("paper", {"goal.door_angle": 1.0}))
    with pytest.raises(DoormanError, match="another scenario"):
        simulate(model, duration=0.1, planner=other)


def test_a_recording_without_truth_cannot_be_judged(model: Model) -> None:
    with pytest.raises(DoormanError, match="no true states"):
        summarize(Recorder(None, {}).recording(), model)
