"""Figures of runs made up by hand, where each is known, and of a short flight, worked out again with numpy."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from doorman import Model, Recording, Scenario, simulate
from doorman.collision.scene import CollisionScene
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.recording import Recorder
from doorman.recording.recording import Topic
from doorman.rig.witness import judge
from doorman.summary import summarize, time_to_open, verdict

KEYS = {
    "outcome", "reason", "hover_to_goal_s", "duration_s", "contact_fraction_after_1s", "estimates", "planned_normal_force_n_min",
    "opened", "final_door_angle_deg", "target_door_angle_deg", "time_to_open_s", "max_constraint_violation_m",
    "min_clearance_m", "collisions", "contact_fraction", "max_pull_force_n", "door_angle_estimate_error_deg_max",
    "went_through", "planner_ms", "planner_rate_hz", "deadline_misses", "realtime_factor", "attempts", "max_push_force_n",
    "final_error", "unit", "final_opening", "target_opening", "true_causes", "free_door_rate_deg_s_max", "judged_by",
}  # fmt: skip


def made_up(model: Model, angles: Any, turn: float = 0.5, **changes: Any) -> Recording:
    """Run with a tick every 0.1 s, the vehicle tied to the leaf, or `away` from there, turning by a share `turn` of its turn.

    `changes` are values of `truth`, `estimate`, `plan` and `mission`.
    """
    m = len(angles)
    columns: dict[str, Any] = {
        "touching": [True] * m, "max_pull": [0.0] * m, "max_push": [2.5] * m, "collisions": [0] * m, "estimated": angles,
        "solve_time": [0.001] * m, "deadline_missed": [False] * m, "wall_time": 0.5, "door_rate": [0.0] * m,
        "only_tip": [False] * m, "away": [np.zeros(3)] * m, "cold": [k == 0 for k in range(m)],
        "deviation": [math.nan] * m,
        "phases": [("open", ""), ("done", ""), ("end", "flown to its end")], **changes,
    }  # fmt: skip
    recorder, arm = Recorder(None, {}), model.goal_arm
    for k, angle in enumerate(angles):
        attitude = np.array([0.0, 0.0, turn * (angle - math.pi / 2)])
        position = model.coupling.vehicle_position(attitude, angle, arm)
        position = position + columns["away"][k]
        truth = {"position": position, "attitude": attitude, "door_angle": angle, "arm_angles": arm}
        names = ("touching", "max_pull", "max_push", "collisions", "door_rate")
        told = {name: columns[name][k] for name in names} | {"only_tip_on_frame": columns["only_tip"][k]}
        recorder.write("truth", 0.1 * k, truth | told)
        state = np.concatenate([attitude, [columns["estimated"][k], 0.0], arm])
        hinge = {"hinge": [0.5, 0.4, 0.1, 5.0], "hinge_deviation": [0.1, 0.2, 0.3, 0.4], "torque_deviation": 0.25}
        recorder.write("estimate", 0.1 * k, {"state": state, **hinge, "door_angle_deviation": columns["deviation"][k]})
        names = ("solve_time", "deadline_missed", "cold")
        plan = {name: columns[name][k] for name in names}
        recorder.write("plan", 0.1 * k, {**plan, "least_normal_force": 0.3 + 0.1 * k})
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
    assert summary["collisions"] == 0 and summary["max_pull_force_n"] == 0.0 and summary["max_push_force_n"] == 2.5
    assert summary["contact_fraction"] == 1.0
    assert summary["door_angle_estimate_error_deg_max"] == pytest.approx(0.0, abs=1e-9)
    assert summary["planner_ms"] == pytest.approx({"median": 1.0, "p99": 1.0, "max": 1.0, "cold": 1.0})
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


SAID = "by its own estimate the door is at 66°"
"""Which does not count where the door is open."""


@pytest.mark.parametrize(
    ("phases", "touched", "outcome", "reason"),
    [
        ([("open", ""), ("done", "why"), ("end", "why")], 0, "given up", "why"),
        (
            [("hover", ""), ("open", ""), ("end", "flown to its end")],
            0,
            "cut off",
            "the flight ended in the phase open",
        ),
        ([("open", ""), ("end", "interrupted")], 0, "interrupted", "interrupted"),
        ([("open", ""), ("end", "failed: link lost")], 0, "failed", "failed: link lost"),
        ([("open", ""), ("done", ""), ("end", f"flown to its end, {SAID}")], 0, "completed", SAID),
        ([("open", ""), ("done", ""), ("end", "flown to its end")], 3, "touched", "3 contacts other than tip and leaf"),
    ],
)
def test_outcomes(model: Model, phases: list[tuple[str, str]], touched: int, outcome: str, reason: str) -> None:
    summary = summarize(made_up(model, OPENING, phases=phases, collisions=[0, 0, touched, 0, 0, 0]), model)
    assert (summary["outcome"], summary["reason"], summary["collisions"]) == (outcome, reason, touched)
    good, sentence = verdict(summary)
    assert summary["opened"] and good is (outcome not in ("given up", "touched"))
    assert ("given up: why" in sentence, "touched (3 contacts" in sentence) == (outcome == "given up", bool(touched))


SHUT = np.radians([90.0, 40.0, 20.0, 45.0, 70.0, 70.0])


@pytest.mark.parametrize(
    ("angles", "rates", "said", "words"),
    [
        (SHUT, [0.0] * 6, "", "the door ended at 70.0°"),
        (np.radians([90.0, 60.0, 21.0, 17.9, 17.9, 17.9]), [0.0] * 6, "", "the door ended at 17.9°"),
        (OPENING, [0.0, 0.0, 0.0, 0.0, 0.02, 0.1], "", "still moved at the end"),
        (SHUT, [0.0] * 6, f", {SAID}", f"the mission said: {SAID}"),
    ],
)
def test_a_mission_that_went_all_its_way_is_judged_by_where_the_door_is(
    model: Model, angles: Any, rates: list[float], said: str, words: str
) -> None:
    phases = [("open", ""), ("done", ""), ("end", f"flown to its end{said}")]
    summary = summarize(made_up(model, angles, phases=phases, door_rate=rates), model)
    assert (summary["outcome"], summary["opened"]) == ("goal missed", False)
    assert summary["time_to_open_s"] is None and words in summary["reason"]
    good, sentence = verdict(summary)
    assert not good and "not opened" in sentence and words in sentence


@pytest.mark.parametrize(("collisions", "outcome"), [([0] * 9, "completed"), ([0] * 7 + [4, 0], "touched")])
def test_a_flight_in_the_rig_counts_what_is_touched_on_the_way_back(
    model: Model, collisions: list[int], outcome: str
) -> None:
    def on_a_clock(run: Recording) -> Recording:
        epoch = Topic("epoch", np.zeros(1), {"epoch": np.array([70.0])})
        return Recording({**run, "epoch": epoch}, run.header, True)

    truth = on_a_clock(made_up(model, [*OPENING, *OPENING[-1:].repeat(3)], collisions=collisions))
    summary = judge(truth, on_a_clock(made_up(model, OPENING)), model)
    assert (summary["outcome"], summary["collisions"]) == (outcome, sum(collisions))


def test_a_door_that_moved_long_before_the_end_stays(model: Model) -> None:
    angles = np.radians([90.0, *[20.0] * 30])
    rates = [*[-1.0] * 15, *[0.0] * 16]
    assert summarize(made_up(model, angles, door_rate=rates), model)["outcome"] == "completed"


def test_constraints_count_wherever_the_vehicle_is(model: Model) -> None:
    """With the whole turn the disc leaves the doorway; beside it, or far before the door, there is nothing to keep clear of."""

    def violation(away: list[float], **changes: Any) -> float:
        run = made_up(model, OPENING, turn=1.0, away=[np.array(away)] * 6, **changes)
        return summarize(run, model)["max_constraint_violation_m"]

    tied = violation([0.0, 0.0, 0.0])
    assert tied > 0.01
    assert violation([0.0, 0.0, 0.0], touching=[False] * 6) == tied
    assert violation([0.0, 0.05, 0.0]) == pytest.approx(tied + 0.05, abs=0.01)
    assert violation([-2.0, 0.0, 0.0]) == violation([-2.0, 0.3, 0.0]) == 0.0


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
        model, OPENING, max_pull=[0.0, 3.5, 1.0, 0.0, 0.0, 0.0], max_push=[1.0, 3.0, 17.5, 0.0, 0.0, 0.0],
        collisions=[0, 0, 2, 1, 0, 0],
        estimated=OPENING + np.radians([0.1, -0.4, 0.2, 0.0, 0.0, 0.0]),
        solve_time=[9.0, 0.001, 0.002, 0.004, 0.003, 0.005],
        deadline_missed=[False, True, False, True, True, False], wall_time=0.25,
    )  # fmt: skip
    summary = summarize(recording, model)
    assert summary["max_pull_force_n"] == 3.5 and summary["max_push_force_n"] == 17.5
    assert summary["collisions"] == 3
    assert summary["door_angle_estimate_error_deg_max"] == pytest.approx(0.4)
    assert summary["planner_ms"]["cold"] == pytest.approx(9000.0)
    assert summary["planner_ms"]["median"] == pytest.approx(3.0)  # without the cold one
    assert summary["planner_ms"]["max"] == pytest.approx(5.0)
    assert summary["planner_ms"]["p99"] == pytest.approx(np.percentile([1.0, 2.0, 4.0, 3.0, 5.0], 99))
    assert summary["deadline_misses"] == 3
    assert summary["realtime_factor"] == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("ticks", "cold", "warm", "coldest"),
    [
        (6, [0, 3], [2.0, 4.0, 3.0, 5.0], 9.0),
        (6, [], [9.0, 2.0, 4.0, 7.0, 3.0, 5.0], None),
        (6, range(6), [], 9.0),
        (1, [0], [], 9.0),
    ],
)
def test_every_cold_plan_has_its_own_figure(
    model: Model, ticks: int, cold: Any, warm: list[float], coldest: float | None
) -> None:
    times = [0.009, 0.002, 0.004, 0.007, 0.003, 0.005]
    cold_ones = [k in cold for k in range(ticks)]
    summary = summarize(made_up(model, OPENING[:ticks], solve_time=times, cold=cold_ones), model)
    found = summary["planner_ms"]
    assert found["cold"] == (None if coldest is None else pytest.approx(coldest))
    if not warm:
        assert found["median"] is found["p99"] is found["max"] is None
    else:
        assert found["median"] == pytest.approx(np.median(warm)) and found["max"] == pytest.approx(max(warm))
    if ticks == 1:
        assert summary["planner_rate_hz"] == summary["realtime_factor"] == 0.0


@pytest.mark.parametrize(
    ("told", "true", "rest"),
    [
        ({}, {}, math.pi / 2),
        ({"door.rest_angle": 2.0}, {}, 2.0),
        ({"door.rest_angle": 2.0}, {"door_rest_angle": 3.5}, 3.5),
    ],
)
def test_the_true_resistance_counts_where_the_closer_is_relaxed(told: dict, true: dict, rest: float) -> None:
    overrides = {"door.friction": 0.3, "simulation.door_stiffness": 0.5, **told}
    overrides |= {f"simulation.{name}": value for name, value in true.items()}
    model = Model(Scenario.load("paper", {"mission.start": "contact", **overrides}))
    torque = summarize(made_up(model, OPENING), model)["estimates"]["torque"]
    assert torque["true"] == pytest.approx(0.3 + 0.5 * (rest - OPENING[-1]))


def test_an_unknown_preload_is_part_of_what_resists() -> None:
    true = []
    for overrides in ({}, {"simulation.door_preload": 2.0}, {"simulation.door_preload": 2.0, "door.preload": 0.5}):
        model = Model(Scenario.load("paper", {"mission.start": "contact", **overrides}))
        true.append(summarize(made_up(model, OPENING), model)["estimates"]["torque"]["true"])
    assert true[1] - true[0] == pytest.approx(2.0) and true[2] - true[0] == pytest.approx(1.5)


def test_the_weight_of_a_leaf_whose_hinge_leans_is_part_of_what_resists() -> None:
    lean = {"simulation.door_lean": [0.0, 0.01], "simulation.door_mass": 20.0}
    true = {}
    for name, overrides in (("plumb", {}), ("leans", lean)):
        model = Model(Scenario.load("paper", {"mission.start": "contact", **overrides}))
        true[name] = summarize(made_up(model, OPENING), model)["estimates"]["torque"]["true"]
    lever = float(np.linalg.norm(model.door._center[:2]))
    weight = 20.0 * 9.81 * lever * math.cos(OPENING[-1])
    assert true["leans"] - true["plumb"] == pytest.approx(0.01 * weight, rel=0.01)


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
        ("hover", "", 0.0), ("touch", "", 0.1), ("open", "", 0.2), ("retreat", "why", 0.4),
        ("hover", "attempt 2, after: why", 0.6), ("touch", "", 0.7), ("open", "", 0.8), ("release", "", 1.0), ("end", "", 1.1),
    ]  # fmt: skip
    touching = [False, False, True, True, False, False, False, False, True, False, False, True]
    run = made_up(model, np.full(12, math.pi / 2), phases=phases, touching=touching)
    summary = summarize(run, model)
    assert summary["attempts"] == 2
    assert summary["contact_fraction"] == pytest.approx(3 / 4), "of 0.2 to 0.4 s and 0.8 to 1.0 s"


def test_a_door_that_is_flung_shut_behind_the_vehicle_counts(model: Model) -> None:
    """Neither the door that the tip still holds, nor one that nobody had in hand yet."""
    phases = [("open", "", 0.0), ("release", "why", 0.2), ("retreat", "why", 0.3), ("end", "why", 0.5)]
    rates, touching = [9.0, 0.2, 0.3, 0.5, -1.5, 0.1], [True, True, True, False, False, False]
    run = made_up(model, OPENING, phases=phases, door_rate=rates, touching=touching)
    assert summarize(run, model)["free_door_rate_deg_s_max"] == pytest.approx(math.degrees(1.5))
    assert summarize(made_up(model, OPENING), model)["free_door_rate_deg_s_max"] is None


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


def test_every_verdict_says_where_the_door_is(model: Model) -> None:
    summary = summarize(made_up(model, OPENING), model)
    assert summary["min_clearance_m"] > 0.0
    for changes, good in (
        ({}, True),
        ({"collisions": 1}, False),
        ({"min_clearance_m": 0.0}, False),
        ({"opened": False, "time_to_open_s": None}, False),
        ({"outcome": "goal missed", "reason": "why", "opened": False}, False),
    ):
        found, sentence = verdict({**summary, **changes})
        assert found is good
        assert "the door ended at 20.5°, 0.5° from the target of 20.0°" in sentence
        assert sentence[0].isupper() and sentence.endswith(".")


def test_the_angle_that_is_stated_is_the_one_that_the_tip_measured_last(model: Model) -> None:
    """A door that is left may shut, and an estimate without a measurement goes anywhere."""
    angles, estimated = [1.5, 1.0, 0.5, 1.2], [1.5, 1.0, 0.51, 0.1]
    recording = made_up(model, angles, estimated=estimated, deviation=[math.nan, 0.02, 0.03, math.nan])
    found = summarize(recording, model)["estimates"]["door_angle"]
    assert found == {"value": pytest.approx(0.51), "deviation": pytest.approx(0.03), "true": pytest.approx(0.5)}
    assert "door_angle" not in summarize(made_up(model, angles), model)["estimates"]


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


def test_a_tip_that_is_to_touch_the_frame_is_no_collision(model: Model) -> None:
    """Its touches count in another phase, and in that phase what else touches; nor is the way back another attempt."""
    states = ["hover", "touch_frame", "hover", "approach", "touch", "open"]
    phases = [(state, "", 0.1 * k) for k, state in enumerate(states)]
    ends = [("done", "", 0.55), ("end", "flown to its end", 0.56)]

    def counted(tick: int, only_tip: bool) -> dict[str, Any]:
        angles = [math.pi / 2] * 6
        run = made_up(
            model, angles, phases=phases + ends, collisions=[2 * (k == tick) for k in range(6)],
            only_tip=[only_tip and k == tick for k in range(6)],
        )  # fmt: skip
        return summarize(run, model)

    assert counted(1, True)["collisions"] == 0
    assert counted(1, False)["collisions"] == 2
    assert counted(3, True)["collisions"] == 2
    assert counted(1, True)["attempts"] == 1


@pytest.mark.parametrize(("then", "counted"), [("retreat", 0), ("approach", 2)])
def test_a_tip_that_leaves_the_frame_as_the_mission_gives_up_is_no_collision(
    model: Model, then: str, counted: int
) -> None:
    phases = [("touch_frame", "", 0.0), (then, "", 0.25), ("done", "", 0.55), ("end", "flown to its end", 0.56)]
    touches = [2 * (k == 3) for k in range(6)]
    run = made_up(model, [math.pi / 2] * 6, phases=phases, collisions=touches, only_tip=[True] * 6)
    assert summarize(run, model)["collisions"] == counted
