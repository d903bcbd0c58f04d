"""Doors that wind or somebody moves, holds or locks while the mission opens them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hands import Torque, flown, hand, phases
from paper_door import door_normal

from doorman.mission import Mission, Phase
from doorman.scenario.sections.task import MissionSection
from doorman.summary import verdict


def pulled_away() -> Torque:
    """By some 20°, faster than the tip can follow."""
    return hand(60.0, 2.0, lambda off, rate: 60.0 * (-math.radians(20.0) - off) - 25.0 * rate)


@pytest.mark.slow
def test_the_leaf_is_touched_gently_again_and_only_as_often_as_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A hand takes the leaf away; with no recovery allowed, the vehicle leaves, and says why."""
    recording, mission = flown(pulled_away())
    assert mission.outcome == (True, "") and "recover" in phases(recording)
    truth = recording["truth"]
    touching = truth["touching"].astype(bool)
    lost = np.flatnonzero(touching[:-1] & ~touching[1:]) + 1
    found = [int(np.flatnonzero(touching[k:])[0]) + k for k in lost if touching[k:].any()]
    lever, again = mission.model.coupling.distance_from_hinge, 0
    for left, k in zip(lost, found, strict=False):
        if truth.time[k] - truth.time[left] > 0.3:  # a bounce is shorter
            before = k - 1
            along = float(door_normal(float(truth["door_angle"][before])) @ truth["velocity"][before])
            assert along + lever * float(truth["door_rate"][before]) < 0.1
            again += 1
    assert again >= 1
    monkeypatch.setattr(MissionSection, "recoveries", 0)
    recording, mission = flown(pulled_away(), mission__attempts=1)
    assert mission.outcome == (False, "contact was lost 1 times")
    assert phases(recording)[-2:] == ["done", "end"]


ATTEMPT = ["hover", "approach", "touch", "open"]


@pytest.mark.slow
def test_an_attempt_that_fails_is_followed_by_another_from_the_hover(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the leaf is by then nobody has told: it is looked for along its swing."""
    monkeypatch.setattr(MissionSection, "recoveries", 0)
    recording, mission = flown(pulled_away())
    assert mission.outcome == (True, "")
    assert phases(recording) == [*ATTEMPT, "retreat", *ATTEMPT, "release", "retreat", "done", "end"]
    told = recording["mission"]["message"][phases(recording).index("retreat") + 1]
    assert told == "attempt 2, after: contact was lost 1 times"
    summary, truth = recording.summary, recording["truth"]
    assert summary is not None and verdict(summary)[0], verdict(summary)[1]
    assert summary["attempts"] == 2
    again = recording["mission"].time[6]
    touched = int(np.flatnonzero(truth["touching"] & (truth.time > again))[0])
    assert math.degrees(truth["door_angle"][touched]) < 60.0, "it was left open"
    assert np.linalg.norm(truth["velocity"][touched]) < 0.15, "it touches gently"


@pytest.mark.slow
def test_who_aborts_wants_no_other_attempt(monkeypatch: pytest.MonkeyPatch) -> None:
    def abort(mission: Mission, time: float, angle: float) -> None:
        if mission.phase is Phase.RETREAT:
            mission.abort("the operator said so")

    monkeypatch.setattr(MissionSection, "recoveries", 0)
    recording, mission = flown(pulled_away(), on_progress=abort)
    assert mission.outcome == (False, "the operator said so")
    assert phases(recording) == [*ATTEMPT, "retreat", "done", "end"]


@pytest.mark.slow
def test_a_door_that_a_person_holds_for_three_seconds_is_opened_and_not_thrown() -> None:
    """The push grows meanwhile; once they let go, the door must stop at the goal by its own friction all the same."""
    recording, mission = flown(hand(30.0, 3.0, lambda off, rate: -60.0 * off - 30.0 * rate))
    assert mission.outcome == (True, "")
    summary = recording.summary
    assert summary is not None and summary["collisions"] == 0
    assert abs(summary["final_door_angle_deg"] - 20.0) < 1.0


@pytest.mark.slow
def test_a_leaf_that_wind_has_opened_is_found_and_opened_from_there() -> None:
    recording, _ = flown(lambda time, angle, rate: -3.0 if time < 0.6 else 0.0)
    assert phases(recording) == ["hover", "approach", "touch", "open", "release", "retreat", "done", "end"]
    summary, truth = recording.summary, recording["truth"]
    assert summary is not None
    touched = int(np.flatnonzero(truth["touching"])[0])
    assert math.degrees(truth["door_angle"][touched]) < 75.0, "it was open"
    assert np.linalg.norm(truth["velocity"][touched]) < 0.15, "it touches gently"
    assert verdict(summary)[0], verdict(summary)[1]


@pytest.mark.slow
@pytest.mark.parametrize(("angle", "found"), [(19.8, True), (19.0, True), (16.0, False)])
def test_a_leaf_that_stands_at_the_goal_already_is_found_there(angle: float, found: bool) -> None:
    """Wind, or an attempt before, may have opened it; farther beyond the goal it is not open as asked."""
    recording, mission = flown(
        lambda time, now, rate: 60.0 * (math.radians(angle) - now) - 30.0 * rate if time < 4.0 else 0.0
    )
    opened, reason = mission.outcome
    summary = recording.summary
    assert summary is not None and summary["collisions"] == 0
    assert summary["final_door_angle_deg"] == pytest.approx(angle, abs=1.0)
    assert opened == found
    assert found or "has opened by itself" in reason
    assert verdict(summary)[0] == found


@pytest.mark.slow
def test_a_door_that_cannot_be_held_at_the_goal_is_given_up() -> None:
    """Somebody stronger than the vehicle shuts it: it was open for a moment, and nobody may be told that it is."""
    shutting: list[float] = []

    def note(mission: Mission, time: float, angle: float) -> None:
        if mission.phase is Phase.HOLD and not shutting:
            shutting.append(time)

    def back(time: float, angle: float, rate: float) -> float:
        off = math.radians(45.0) - angle
        return min(60.0 * off, 5.0) - 30.0 * rate if shutting else 0.0

    recording, mission = flown(back, on_progress=note, mission__attempts=1, simulation__door_stiffness=1.0)
    opened, reason = mission.outcome
    assert not opened and "could not be held at the goal" in reason
    assert "hold" in phases(recording) and phases(recording)[-3:] == ["retreat", "done", "end"]
    summary = recording.summary
    assert summary is not None and summary["collisions"] == 0
    assert not verdict(summary)[0]


@pytest.mark.slow
@pytest.mark.parametrize("scenario", ["push", "paper"])
def test_a_vehicle_that_comes_back_leaves_a_door_that_would_not_stay(scenario: str) -> None:
    """Nobody has taken it: the leaf shuts behind the vehicle, and does not throw it onto the jambs."""
    recording, mission = flown(
        scenario=scenario, comes_back=True, simulation__door_stiffness=1.0, mission__time_out__hold=6.0
    )
    assert mission.outcome == (False, "the door did not stay by itself, and the vehicle let go after 6 s")
    back = ["take_back"] if scenario == "paper" else []
    assert phases(recording) == [*ATTEMPT, "hold", *back, "release", "retreat", "done", "end"]
    summary, truth = recording.summary, recording["truth"]
    assert summary is not None and summary["collisions"] == 0
    left = recording["mission"].time[phases(recording).index("hold") + 1]
    assert abs(math.degrees(truth["door_angle"][np.searchsorted(truth.time, left)]) - 20.0) < 2.0, "held until then"
    assert truth["position"][-1, 0] < -0.8, "out of the doorway"


@pytest.mark.slow
def test_who_takes_a_held_door_is_not_approached_again() -> None:
    """A person moves it by 6° out of the gripper's hold: they have it, and the vehicle leaves for good."""
    taken: list[float] = []

    def note(mission: Mission, time: float, angle: float) -> None:
        if mission.phase is Phase.HOLD and not taken:
            taken.append(time + 8.0)

    def person(time: float, angle: float, rate: float) -> float:
        there = taken and time > taken[0]
        return 60.0 * (math.radians(26.0) - angle) - 30.0 * rate if there else 0.0

    recording, mission = flown(
        person, scenario="paper", on_progress=note, comes_back=True, simulation__door_stiffness=1.0
    )
    opened, reason = mission.outcome
    assert not opened and "the door was moved while it was held" in reason
    assert phases(recording) == [*ATTEMPT, "hold", "release", "retreat", "done", "end"]
    summary = recording.summary
    assert summary is not None and summary["collisions"] == 0


@pytest.mark.slow
def test_a_leaf_that_is_blown_past_the_goal_is_not_chased() -> None:
    recording, mission = flown(hand(50.0, 6.0, lambda off, rate: -3.0 - 5.0 * rate))
    opened, reason = mission.outcome
    assert not opened and "the leaf has gone past the goal" in reason
    assert phases(recording)[-3:] == ["retreat", "done", "end"]
    summary, truth = recording.summary, recording["truth"]
    assert summary is not None and summary["collisions"] == 0
    assert truth["position"][-1, 0] < -0.8, "out of the doorway"


@pytest.mark.slow
def test_a_bolted_door_is_pushed_as_hard_as_allowed_and_left_alone() -> None:
    recording, mission = flown(simulation__door_latch=100.0)
    opened, reason = mission.outcome
    assert not opened and "does not move on from" in reason and "N m" in reason
    assert phases(recording)[-4:] == ["release", "retreat", "done", "end"]
    summary = recording.summary
    assert summary is not None and summary["collisions"] == 0 and summary["attempts"] == 1
    assert 9.0 < summary["max_push_force_n"] <= 12.5


@pytest.mark.parametrize("stop", [89.9, pytest.param(45.0, marks=pytest.mark.slow)])
def test_a_gripped_door_that_is_locked_does_not_turn_the_vehicle_onto_itself(stop: float) -> None:
    """What leans on a door that does not give way is turned about its tip, and plans turn with a door that should move."""

    def bolt(time: float, angle: float, rate: float) -> float:
        return float(np.clip(4000.0 * (math.radians(stop) - angle) - 100.0 * rate, -40.0, 40.0))

    recording, mission = flown(lambda time, angle, rate: max(bolt(time, angle, rate), 0.0), "paper")
    opened, reason = mission.outcome
    assert not opened and ("heading is lost" in reason or "does not move on" in reason or "come too near to" in reason)
    assert phases(recording)[-4:] == ["release", "retreat", "done", "end"]
    assert recording.summary is not None and recording.summary["collisions"] == 0
    truth = recording["truth"]
    ahead = -truth["attitude"][:, 2] - (math.pi / 2 - truth["door_angle"])
    assert np.degrees(ahead).max() < 50.0


def test_a_gripper_that_pulls_is_unloaded_before_it_opens() -> None:
    """Somebody has opened the door too far and holds it there: what lets go of a load is flung at the jamb."""
    held = hand(24.0, math.inf, lambda off, rate: 300.0 * (-math.radians(12.0) - off) - 150.0 * rate)
    recording, _ = flown(held, "paper", mission__attempts=1, mission__start="contact")
    truth, command, release = recording["truth"], recording["command"], phases(recording).index("release")
    assert "gone past the goal" in recording["mission"]["message"][release - 1]
    assert "does not go back" in recording["mission"]["message"][release]
    given_up = recording["mission"].time[release]
    let_go = command.time[np.flatnonzero(command["grip"])[-1]]
    pull = np.abs(truth["tip_normal_force"])
    before, then = np.searchsorted(truth.time, [given_up, let_go])
    assert pull[before] > 4.0 and pull[then] < 3.0
    after = (truth.time > given_up) & (truth.time < let_go + 0.5)
    assert truth["velocity"][after, 1].max() < 0.25, "towards the jamb"
    assert recording.summary is not None and recording.summary["collisions"] == 0
