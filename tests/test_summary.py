"""Figures of runs made up by hand, where each is known, and of a short flight, worked out again with numpy."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from doorman import Model, Recording, simulate
from doorman.collision.scene import CollisionScene
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.recording import Recorder
from doorman.summary import summarize, time_to_open, verdict

KEYS = {
    "outcome", "reason", "hover_to_goal_s", "duration_s", "contact_fraction_after_1s", "estimates", "planned_normal_force_n_min",
    "opened", "final_door_angle_deg", "target_door_angle_deg", "time_to_open_s", "max_constraint_violation_m",
    "min_clearance_m", "collisions", "contact_fraction", "max_pull_force_n", "door_angle_estimate_error_deg_max",
    "planner_ms", "planner_rate_hz", "deadline_misses", "realtime_factor", "attempts",
}  # fmt: skip


def made_up(model: Model, angles: Any, turn: float = 0.5, **changes: Any) -> Recording:
    """Run with a tick every 0.1 s, the vehicle tied to the leaf and turning by a share `turn` of the leaf's own turn.

    `changes` are values of `truth`, `estimate`, `plan` and `mission`.
    """
    m = len(angles)
    columns: dict[str, Any] = {
        "touching": [True] * m, "max_pull": [0.0] * m, "collisions": [0] * m, "estimated": angles,
        "solve_time": [0.001] * m, "deadline_missed": [False] * m, "wall_time": 0.5,
        "phases": [("open", ""), ("done", ""), ("end", "flown to its end")], **changes,
    }  # fmt: skip
    recorder, arm = Recorder(None, {}), model.goal_arm
    for k, angle in enumerate(angles):
        attitude = np.array([0.0, 0.0, turn * (angle - math.pi / 2)])
        position = model.coupling.vehicle_position(attitude, angle, arm)
        truth = {"position": position, "attitude": attitude, "door_angle": angle, "door_rate": 0.0, "arm_angles": arm}
        names = ("touching", "max_pull", "collisions")
        recorder.write("truth", 0.1 * k, {**truth, **{name: columns[name][k] for name in names}})
        state = np.concatenate([attitude, [columns["estimated"][k], 0.0], arm])
        hinge = {"hinge": [0.5, 0.4, 0.1, 5.0], "hinge_deviation": [0.1, 0.2, 0.3, 0.4], "torque_deviation": 0.25}
        recorder.write("estimate", 0.1 * k, {"state": state, **hinge})
        names = ("solve_time", "deadline_missed")
        plan = {name: columns[name][k] for name in names}
        recorder.write("plan", 0.1 * k, {**plan, "normal_force": [0.3 + 0.1 * k, 0.7]})
    for state, message, *at in columns["phases"]:
        time = at[0] if at else 0.1 * (m - 1)
        recorder.write("mission", time, {"state": state, "message": message, "wall_time": columns["wall_time"]})
    return recorder.recording()


OPENING = np.radians([90.0, 60.0, 21.0, 30.0, 21.9, 20.5])


def test_a_run_that_opens_the_door(model: Model) -> None:
    summary = summarize(made_up(model, OPENING), model)
    assert set(summary) == KEYS
    assert summary["opened"] is True
    assert summary["time_to_open_s"] == pytest.approx(0.4)  # not at 0.2: it left again
    assert summary["final_door_angle_deg"] == pytest.approx(20.5)
    assert summary["target_door_angle_deg"] == pytest.approx(20.0)
    assert summary["collisions"] == 0 and summary["max_pull_force_n"] == 0.0
    assert summary["contact_fraction"] == 1.0
    assert summary["door_angle_estimate_error_deg_max"] == pytest.approx(0.0, abs=1e-9)
    assert summary["planner_ms"] == pytest.approx({"median": 1.0, "p99": 1.0, "max": 1.0})
    assert summary["planner_rate_hz"] == pytest.approx(10.0)
    assert summary["realtime_factor"] == pytest.approx(1.0)
    assert (summary["outcome"], summary["reason"]) == ("completed", "")
    assert summary["hover_to_goal_s"] == pytest.approx(0.4) and summary["duration_s"] == pytest.approx(0.5)
    assert summary["planned_normal_force_n_min"] == pytest.approx(0.3)
    friction, torque = summary["estimates"]["friction"], summary["estimates"]["torque"]
    assert (friction["value"], friction["deviation"], friction["true"]) == (0.4, 0.2, model.door.friction)
    assert torque["value"] == pytest.approx(0.4 + 0.1 * math.radians(90.0 - 20.5))
    good, sentence = verdict(summary)
    assert good and "0.40 s" in sentence and "20.5°" in sentence


def test_time_to_open_counts_from_the_first_touch(model: Model) -> None:
    summary = summarize(made_up(model, OPENING, touching=[False, True, True, True, True, True]), model)
    assert summary["time_to_open_s"] == pytest.approx(0.3) and summary["hover_to_goal_s"] == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("phases", "outcome", "reason"),
    [
        ([("open", ""), ("done", "why"), ("end", "why")], "given up", "why"),
        ([("hover", ""), ("open", ""), ("end", "flown to its end")], "cut off", "the flight ended in the phase open"),
        ([("open", ""), ("end", "interrupted")], "interrupted", "interrupted"),
        ([("open", ""), ("end", "failed: link lost")], "failed", "failed: link lost"),
    ],
)
def test_outcomes(model: Model, phases: list[tuple[str, str]], outcome: str, reason: str) -> None:
    summary = summarize(made_up(model, OPENING, phases=phases), model)
    assert (summary["outcome"], summary["reason"]) == (outcome, reason)
    if outcome == "given up":
        good, sentence = verdict(summary)
        assert not good and "given up: why" in sentence


def test_constraints_count_only_while_the_tip_is_at_the_door(model: Model) -> None:
    """With the whole turn the disc leaves the doorway; not while the tip was away."""
    tied = summarize(made_up(model, OPENING, turn=1.0), model)["max_constraint_violation_m"]
    away = summarize(made_up(model, OPENING, turn=1.0, touching=[False] * 6), model)["max_constraint_violation_m"]
    assert tied > 0.01 and away == 0.0


def test_violation_and_clearance_are_of_the_true_states(model: Model) -> None:
    recording = made_up(model, OPENING, turn=1.0)
    summary, truth = summarize(recording, model), recording["truth"]
    scene = CollisionScene(model.vehicle, model.door)
    worst, nearest = 0.0, math.inf
    for k in range(len(truth.time)):
        angle, arm, attitude = truth["door_angle"][k], truth["arm_angles"][k], truth["attitude"][k]
        worst = max(worst, model.constraints([*attitude, angle, 0.0, *arm]).max())
        found = scene.min_clearance(truth["position"][k], rotation_body_to_world(attitude), arm, angle)
        nearest = min(nearest, found.distance)
    assert worst > 0.01 and nearest < 0.0  # at right angles to the leaf the disc leaves the doorway
    assert summary["max_constraint_violation_m"] == pytest.approx(worst, abs=1e-12)
    assert summary["min_clearance_m"] == pytest.approx(nearest, abs=1e-9)


def test_worst_values_are_of_the_whole_run(model: Model) -> None:
    recording = made_up(
        model, OPENING, max_pull=[0.0, 3.5, 1.0, 0.0, 0.0, 0.0], collisions=[0, 0, 2, 1, 0, 0],
        estimated=OPENING + np.radians([0.1, -0.4, 0.2, 0.0, 0.0, 0.0]),
        solve_time=[9.0, 0.001, 0.002, 0.004, 0.003, 0.005],
        deadline_missed=[False, True, False, True, True, False], wall_time=0.25,
    )  # fmt: skip
    summary = summarize(recording, model)
    assert summary["max_pull_force_n"] == 3.5
    assert summary["collisions"] == 3
    assert summary["door_angle_estimate_error_deg_max"] == pytest.approx(0.4)
    assert summary["planner_ms"]["median"] == pytest.approx(3.0)  # the first plan is cold and does not count
    assert summary["planner_ms"]["max"] == pytest.approx(5.0)
    assert summary["planner_ms"]["p99"] == pytest.approx(np.percentile([1.0, 2.0, 4.0, 3.0, 5.0], 99))
    assert summary["deadline_misses"] == 3
    assert summary["realtime_factor"] == pytest.approx(2.0)


def test_an_estimate_a_turn_off_is_no_error(model: Model) -> None:
    angles = np.array([3.1, 3.1])
    recording = made_up(model, angles, estimated=np.array([-3.1, 3.0]))
    error = summarize(recording, model)["door_angle_estimate_error_deg_max"]
    assert error == pytest.approx(math.degrees(0.1), abs=1e-9)


@pytest.mark.parametrize(
    ("touching", "fraction"),
    [
        ([False] * 6, 0.0),
        ([True] * 6, 1.0),
        ([False, False, True, True, True, False], 0.75),  # counts from the first touch on
        ([True, False, False, True, True, False], 0.5),
        ([False, True, False, False, False, True], 0.4),
        ([False, False, False, False, False, True], 1.0),
    ],
)
def test_share_of_time_in_contact(model: Model, touching: list[bool], fraction: float) -> None:
    summary = summarize(made_up(model, OPENING, touching=touching), model)
    assert summary["contact_fraction"] == pytest.approx(fraction)


def test_between_attempts_the_tip_is_not_at_the_door(model: Model) -> None:
    """Nor is the clearance of the planner's constraints asked for there: they take for granted that it is."""
    phases = [
        *[("hover", "", 0.0), ("touch", "", 0.1), ("open", "", 0.2), ("retreat", "why", 0.4)],
        *[
            ("hover", "attempt 2, after: why", 0.6),
            ("touch", "", 0.7),
            ("open", "", 0.8),
            ("release", "", 1.0),
            ("end", "", 1.1),
        ],
    ]
    touching = [False, False, True, True, False, False, False, False, True, False, False, True]
    run = made_up(model, np.full(12, math.pi / 2), phases=phases, touching=touching)
    summary = summarize(run, model)
    assert summary["attempts"] == 2
    assert summary["contact_fraction"] == pytest.approx(3 / 4), "of 0.2 to 0.4 s and 0.8 to 1.0 s"


def test_share_of_time_in_contact_of_a_door_that_stays_shut(model: Model) -> None:
    touching = [False, True, True, False, False, True]
    summary = summarize(made_up(model, np.full(6, math.pi / 2), touching=touching), model)
    assert summary["contact_fraction"] == pytest.approx(0.6)
    assert summary["opened"] is False and summary["time_to_open_s"] is None
    good, sentence = verdict(summary)
    assert not good and "not opened" in sentence and "60%" in sentence and "90.0°" in sentence


@pytest.mark.parametrize(
    ("degrees", "expected"),
    [
        ([20.0], 0.0),
        ([25.0], None),
        ([25.0, 20.0], 1.0),
        ([20.0, 25.0], None),
        ([18.1, 21.9, 20.0], 0.0),
        ([20.0, 17.9, 20.0], 2.0),
        ([20.0, 22.1, 20.0, 20.0], 2.0),
    ],
)
def test_time_to_open(degrees: list[float], expected: float | None) -> None:
    found = time_to_open(np.arange(float(len(degrees))), np.radians(degrees), math.radians(20.0))
    assert found == expected


def test_a_run_of_one_tick(model: Model) -> None:
    summary = summarize(made_up(model, OPENING[:1], solve_time=[0.02]), model)
    assert summary["planner_ms"]["max"] == pytest.approx(20.0)
    assert summary["planner_rate_hz"] == 0.0
    assert summary["realtime_factor"] == 0.0


def test_every_verdict_says_where_the_door_is(model: Model) -> None:
    summary = summarize(made_up(model, OPENING), model)
    assert summary["min_clearance_m"] > 0.0
    for changes, good in (
        ({}, True),
        ({"collisions": 1}, False),
        ({"min_clearance_m": 0.0}, False),
        ({"opened": False, "time_to_open_s": None}, False),
    ):
        found, sentence = verdict({**summary, **changes})
        assert found is good
        assert "the door ended at 20.5°, 0.5° from the target of 20.0°" in sentence
        assert sentence[0].isupper() and sentence.endswith(".")


def test_a_flight_gives_the_same_figures_from_memory_and_from_its_file(model: Model, tmp_path) -> None:
    flown = simulate(model, duration=0.3, seed=1, path=tmp_path / "run.mcap")
    loaded = Recording.load(tmp_path / "run.mcap")
    assert summarize(loaded, model) == flown.summary
    truth, summary = flown["truth"], flown.summary
    assert summary is not None
    states = np.column_stack([truth["attitude"], truth["door_angle"], truth["door_rate"], truth["arm_angles"]])
    assert summary["max_constraint_violation_m"] == max(0.0, max(model.constraints(x).max() for x in states))
    error = np.degrees(np.abs(flown["estimate"]["state"][:, 3] - truth["door_angle"])).max()
    assert summary["door_angle_estimate_error_deg_max"] == pytest.approx(error, rel=1e-9)
    assert summary["realtime_factor"] == pytest.approx(0.3 / flown["mission"]["wall_time"][-1])
