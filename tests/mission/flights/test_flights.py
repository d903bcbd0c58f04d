"""Whole flights on the simulator: the numbers that doorman promises, and what happens when something goes wrong."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from urdf_variants import write_arm, write_door

from doorman import Model, Planner, PlanStatus, Scenario, simulate
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


@pytest.mark.parametrize("kind", ["paper", pytest.param("pushed", marks=pytest.mark.slow)])
def test_a_minute_is_recorded_in_twenty_megabytes(kind: str, folder: Path, request: pytest.FixtureRequest) -> None:
    minutes = request.getfixturevalue(kind)["truth"].time[-1] / 60.0
    assert (folder / f"{kind}.mcap").stat().st_size < 20e6 * minutes


PHASES = ["hover", "approach", "touch", "open", "release", "retreat", "done", "end"]


@pytest.mark.parametrize("kind", ["paper", "pushed"])
def test_the_mission_goes_from_hover_to_hover(kind: str, request: pytest.FixtureRequest) -> None:
    recording = request.getfixturevalue(kind)
    mission, truth, scenario = recording["mission"], recording["truth"], Scenario.load("paper")
    assert mission["state"].tolist() == PHASES
    assert not any(mission["message"][:-1])
    for place in (0, -1):
        assert (
            truth["position"][place, 0] < -0.4 - 0.9 * scenario.mission.hover_distance
        )  # the disc is out of the doorway
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
    assert abs(found - true) <= max(0.2, 0.25 * true)


def test_the_tips_force_is_estimated(pushed: Recording) -> None:
    truth, estimate = pushed["truth"], pushed["estimate"]
    moving = (truth.time > 10.0) & (truth.time < 20.0)
    average = np.convolve(
        truth["tip_normal_force"], np.full(125, 1 / 125), mode="same"
    )  # it lags by a tenth of a second
    found = np.convolve(estimate["normal_force"], np.full(125, 1 / 125), mode="same")
    assert np.abs(average - found)[moving].mean() < 0.2


def test_summary_is_what_the_recording_says(paper: Recording, model: Model) -> None:
    truth, summary = paper["truth"], paper.summary
    assert summary is not None
    angle = np.degrees(truth["door_angle"])
    assert summary["final_door_angle_deg"] == pytest.approx(angle[-1])
    outside = truth.time[np.abs(angle - 20.0) >= 2.0]
    touched, let_go = (np.flatnonzero(truth["touching"])[i] for i in (0, -1))
    assert summary["hover_to_goal_s"] == pytest.approx(outside[-1] + 0.004, abs=1e-6)
    assert summary["time_to_open_s"] == pytest.approx(outside[-1] + 0.004 - truth.time[touched], abs=1e-6)
    worst = max(
        model.constraints([*truth["attitude"][k], truth["door_angle"][k], 0.0, *truth["arm_angles"][k]]).max()
        for k in range(touched, let_go, 25)
    )
    assert worst <= max(summary["max_constraint_violation_m"], 1e-12) or worst < 0.0
    assert summary["max_pull_force_n"] >= -truth["tip_normal_force"].min() - 1e-9
    solve_times = paper["plan"]["solve_time"][1:] * 1e3
    assert summary["planner_ms"]["max"] == pytest.approx(solve_times.max())


def test_every_plan_that_was_flown_keeps_the_constraints(paper: Recording, model: Model) -> None:
    plan, margin = paper["plan"], model.scenario.planner.margin
    for k in range(0, len(plan.time), 40):
        assert model.constraints_along(plan["states"][k][1:]).max() <= -margin + 1e-6


def test_same_seed_same_flight(model: Model) -> None:
    first, second = (simulate(model, duration=0.5, seed=3) for _ in range(2))
    other = simulate(model, duration=0.5, seed=4)
    for field in ("position", "door_angle", "tip_force"):
        np.testing.assert_array_equal(first["truth"][field], second["truth"][field])
    assert (first["measurement"]["position"] != other["measurement"]["position"]).any()


@pytest.mark.parametrize(
    ("width", "mass", "contact", "rod", "resistance"),
    [pytest.param(1.5, 6.0, 1.0, 0.35, 0.0, marks=pytest.mark.slow), (1.15, 18.0, 0.6, 0.24, 0.6)],
)
def test_other_doors_and_arms(
    tmp_path: Path, width: float, mass: float, contact: float, rod: float, resistance: float
) -> None:
    door = write_door(tmp_path / "door.urdf", width=width, mass=mass, damping=resistance, friction=resistance)
    arm = write_arm(tmp_path / "arm.urdf", rod=rod)
    overrides = {"vehicle.urdf": str(arm), "door.urdf": str(door), "contact.distance_from_hinge": contact,
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


class FailingPlanner(Planner):
    """Planner whose plans are of no use from some call on."""

    good_plans = 30

    def replan(self, state, elapsed=None, **options):
        plan = super().replan(state, elapsed, **options)
        self.good_plans -= 1
        if self.good_plans > 0:
            return plan
        return dataclasses.replace(plan, status=PlanStatus.INFEASIBLE)


def test_the_plan_may_fail_but_the_flight_goes_on(model: Model) -> None:
    recording = simulate(model, duration=3.5, planner=FailingPlanner(model))
    assert (recording["plan"]["status"][-50:] == "infeasible").all()
    assert recording["truth"].time[-1] == pytest.approx(3.5)
    late = recording["setpoint"].time > 2.5  # the last usable plan, of about 0.3 s, has ended
    assert np.abs(recording["setpoint"]["velocity"][late]).max() < 1e-9
    assert np.abs(recording["truth"]["velocity"][-1]).max() < 0.2
    assert recording["truth"]["collisions"].sum() == 0


def test_a_planner_of_another_scenario_is_refused(model: Model) -> None:
    other = Planner(Scenario.load("paper", {"goal.door_angle": 1.0}))
    with pytest.raises(DoormanError, match="another scenario"):
        simulate(model, duration=0.1, planner=other)


def test_a_recording_without_truth_cannot_be_judged(model: Model) -> None:
    with pytest.raises(DoormanError, match="no true states"):
        summarize(Recorder(None, {}).recording(), model)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"collisions": 3}, "Something was touched"),
        ({"min_clearance_m": -0.002}, "overlap by 2.0 mm"),
        ({"opened": False, "time_to_open_s": None}, "was not opened"),
    ],
)
def test_verdicts(paper: Recording, changes: dict, words: str) -> None:
    assert paper.summary is not None
    good, sentence = verdict({**paper.summary, **changes})
    assert not good and words in sentence
