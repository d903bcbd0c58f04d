"""Doors that shut, or are slammed, with the vehicle at the leaf or on its way out."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from hands import Slam, flown, phases, touched
from urdf_variants import DOOR, write_edited

from doorman.mission import Mission, Phase

NARROW = {"door__width": 1.1, "simulation__door_width": 1.1, "simulation__door_stiffness": 2.0}
SHUTTING = [
    ("paper", 45.0, 0.0, {"simulation__door_stiffness": 2.0}),
    pytest.param("push", 30.0, 0.0, NARROW, marks=pytest.mark.slow),
    pytest.param("push", 25.0, 3.0, {}, marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("scenario", "below", "shove", "hinge"), SHUTTING)
def test_a_leaf_that_shuts_on_a_vehicle_that_backs_out_meets_its_tip(
    scenario: str, below: float, shove: float, hinge: dict[str, float]
) -> None:
    """A closer, or somebody, shuts the door as soon as it is let go: rotors, arm and jambs stay clear of each other."""
    given_up: list[float] = []

    def give_up(mission: Mission, time: float, angle: float) -> None:
        if not given_up and angle < math.radians(below):
            mission.abort("the operator said so")
            given_up.append(time)

    recording, mission = flown(
        lambda time, angle, rate: shove if given_up else 0.0,
        scenario,
        give_up,
        simulation__door_mass=6.0,
        simulation__door_friction=0.3,
        **hinge,
    )
    assert mission.outcome == (False, "the operator said so")
    summary, truth = recording.summary, recording["truth"]
    assert summary is not None and summary["collisions"] == 0
    assert math.degrees(truth["door_angle"][-1]) > 85.0, "it has shut"
    assert truth["position"][-1, 0] < -0.8


SLOW = [pytest.param("paper", 27.0, marks=pytest.mark.slow), pytest.param("push", 50.0, marks=pytest.mark.slow)]


@pytest.mark.parametrize(("scenario", "angle"), [("paper", 50.0), *SLOW])
def test_a_slammed_door_does_not_throw_the_vehicle_onto_jambs_or_leaf(scenario: str, angle: float) -> None:
    """At 1 rad/s from where it opens. What bounces for a moment is the last servo, behind the tip."""
    slam: list[bool] = []

    def hand(time: float, now: float, rate: float) -> float:
        if now < math.radians(angle) and not slam:
            slam.append(True)
        if slam and rate > 1.0:
            slam[0] = False
        return 150.0 if slam and slam[0] else 0.0

    recording, mission = flown(hand, scenario)
    truth = recording["truth"]
    assert slam == [False] and truth["door_rate"].max() > 0.95
    assert any("slammed" in reason for reason in recording["mission"]["message"].tolist())
    assert touched(recording) <= {"servo_4_0 and leaf"}
    assert np.count_nonzero(truth["collision_pairs"]) < 20
    opened, reason = mission.outcome
    assert opened or "does not hold" in reason, "at the second attempt, unless the slam passes for a slip"


GOING = [
    ("paper", Phase.RELEASE, 0.0),
    ("paper", Phase.RELEASE, 0.3),
    ("paper", Phase.RETREAT, 0.8),
    ("push", Phase.RELEASE, 4.9),
    ("push", Phase.RETREAT, 0.5),
]


@pytest.mark.slow
@pytest.mark.parametrize(("scenario", "phase", "later"), GOING)
def test_a_door_slammed_at_the_goal_does_not_throw_the_vehicle_onto_the_jamb(
    scenario: str, phase: Phase, later: float
) -> None:
    """It is thrown at it, from 11 cm, and is struck once more by the leaf that follows it."""
    slam = Slam(phase, later)
    recording, mission = flown(slam, scenario, on_progress=slam.watch)
    assert slam.thrown is not None
    told = " ".join(recording["mission"]["message"].tolist())
    assert re.search(r"slammed at 2[0-4]°", told), "a closed gripper is taken along until that is felt"
    assert touched(recording) <= {"servo_4_0 and leaf"}
    opened, reason = mission.outcome  # at the second attempt, which a push may give up where it does not find the leaf
    assert (opened, reason) == (True, "") or (scenario == "push" and "the leaf has gone past the goal" in reason)


@pytest.mark.slow
@pytest.mark.parametrize("later", [1.5, 2.5])
def test_a_door_slammed_at_a_vehicle_that_goes_out_meets_its_tip(later: float) -> None:
    """Heading and arm turn back as it goes, for the place where a leaf would meet it."""
    slam = Slam(Phase.RETREAT, later)
    recording, _ = flown(slam, "paper", on_progress=slam.watch)
    assert slam.thrown is not None and np.degrees(recording["truth"]["door_angle"]).max() > 60.0
    assert touched(recording) <= {"servo_4_0 and leaf"}


@pytest.mark.slow
def test_a_tip_thrown_back_as_it_comes_to_the_leaf_does_not_grip_the_air(tmp_path: Path) -> None:
    """It stands for no moment: what it was thrown back from is no leaf that has come nearer, of a door without a stop."""
    door = write_edited(tmp_path / "door.urdf", DOOR, ('upper="1.5708"', 'upper="1.7"'))
    slam = Slam(Phase.TOUCH, later=0.2)
    recording, mission = flown(slam, "paper", on_progress=slam.watch, door__urdf=str(door))
    estimate, command = recording["estimate"], recording["command"]
    assert slam.thrown is not None and recording["truth"]["velocity"][:, 0].min() < -0.4
    gripped = np.interp(estimate.time, command.time, command["grip"].astype(float)) > 0.5
    assert np.degrees(estimate["state"][gripped, 3]).max() < 97.0, "it closes at 90°, and tugs a leaf that has no stop"
    assert mission.outcome == (True, "")


def test_a_vehicle_that_is_pulled_back_in_free_flight_has_still_opened_its_door() -> None:
    """As fast as a slammed door would throw it."""
    begun: list[float] = []

    def when_free(mission: Mission, time: float, angle: float) -> None:
        if mission.phase is Phase.RETREAT and not begun:
            begun.append(time + 0.5)

    def pull(time: float) -> float:
        return -12.0 if begun and 0.0 < time - begun[0] < 0.5 else 0.0

    recording, mission = flown(scenario="paper", on_progress=when_free, pull=pull, mission__start="contact")
    assert recording["truth"]["velocity"][:, 0].min() < -1.0
    assert phases(recording)[-4:] == ["release", "retreat", "done", "end"]
    summary = recording.summary
    assert summary is not None and abs(summary["final_error"]) < 1.5 and summary["collisions"] == 0
