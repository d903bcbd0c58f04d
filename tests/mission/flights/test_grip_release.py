"""A gripped door is let go where it stays by itself, and held where it does not; a gripper that does not close is noticed."""

from __future__ import annotations

import numpy as np
import pytest
from hands import Slam, flown, phases

from doorman import Model, Recording
from doorman.campaign import judge
from doorman.campaign.judgement import told_truly
from doorman.mission import Phase
from doorman.summary import verdict

TOLD = {"simulation__door_damping": 0.3, "mission__start": "contact"}


def ends_held(recording: Recording) -> None:
    summary = recording.summary
    assert summary is not None and (summary["outcome"], summary["opened"]) == ("completed", True)
    assert verdict(summary)[0] and judge(summary).success
    assert abs(summary["final_door_angle_deg"] - 20.0) < 1.5 and summary["collisions"] == 0
    assert phases(recording)[-3:] == ["hold", "done", "end"]
    assert recording["command"]["grip"][-1], "the gripper stays closed"
    assert np.abs(np.degrees(recording["truth"]["door_rate"][-250:])).mean() < 0.5


def test_a_door_that_moves_as_the_load_is_taken_off_it_is_held() -> None:
    """Its closer is a little stronger than its friction, which the estimates cannot tell."""
    recording, mission = flown(scenario="paper", simulation__door_friction=0.2, simulation__door_stiffness=0.4, **TOLD)
    assert mission.outcome == (True, "")
    assert phases(recording)[:4] == ["touch", "open", "release", "hold"]
    ends_held(recording)
    began, held = (recording["mission"].time[phases(recording).index(name)] for name in ("release", "hold"))
    during = (recording["command"].time > began) & (recording["command"].time < held)
    assert recording["command"]["grip"][during].all(), "it is watched before the gripper opens"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("friction", "stiffness"), [(0.1, 0.25), (0.3, 0.5), (0.1, 1.0), (0.5, 1.5), (1.0, 1.0), (0.3, 2.0)]
)
def test_a_door_whose_closer_is_stronger_is_held(friction: float, stiffness: float) -> None:
    recording, mission = flown(
        scenario="paper", simulation__door_friction=friction, simulation__door_stiffness=stiffness, **TOLD
    )
    assert mission.outcome == (True, "")
    ends_held(recording)


@pytest.mark.slow
@pytest.mark.parametrize(("friction", "stiffness"), [(0.3, 0.0), (1.0, 0.25), (1.0, 0.5)])
def test_a_door_whose_friction_is_stronger_is_left(friction: float, stiffness: float) -> None:
    recording, mission = flown(
        scenario="paper", simulation__door_friction=friction, simulation__door_stiffness=stiffness, **TOLD
    )
    assert mission.outcome == (True, "")
    assert phases(recording)[-4:] == ["release", "retreat", "done", "end"]
    summary = recording.summary
    assert summary is not None and judge(summary).success and not recording["command"]["grip"][-1]


def test_a_door_that_is_shut_behind_the_vehicle_is_not_completed() -> None:
    """The mission does not see it; the summary asks the truth."""
    slam = Slam(Phase.RETREAT, later=4.0)
    recording, mission = flown(slam, scenario="paper", on_progress=slam.watch, mission__start="contact")
    assert slam.thrown is not None
    summary = recording.summary
    assert summary is not None and (summary["outcome"], summary["opened"]) == ("goal missed", False)
    assert summary["final_door_angle_deg"] > 22.0 and not verdict(summary)[0] and not judge(summary).success
    assert recording["mission"]["message"][-1] == "flown to its end" or mission.outcome[1]


@pytest.mark.parametrize("start", ["hover", "contact"])
def test_a_gripper_that_never_closes_is_noticed(start: str) -> None:
    recording, mission = flown(scenario="paper", simulation__gripper_force=0.0, mission__start=start)
    assert mission.outcome == (False, "the gripper does not hold the leaf")
    summary, told = recording.summary, recording["command"]["grip"]
    assert summary is not None and summary["outcome"] == "given up" and summary["collisions"] == 0
    assert summary["true_causes"] == ["the gripper never closed"] and not judge(summary).success
    assert "the gripper does not hold the leaf" in verdict(summary)[1]
    assert "open" not in phases(recording), "noticed before the door moves"
    closed = recording["command"].time[told]
    assert closed[-1] - closed[0] < (1.5 if start == "hover" else 1.0)
    assert np.degrees(recording["truth"]["door_angle"]).min() > 85.0


@pytest.mark.slow
@pytest.mark.parametrize("direction", [0.3, 0.5, 0.7])
def test_a_leaf_that_wind_moves_is_no_fault_of_the_gripper(direction: float) -> None:
    """It stands elsewhere when the tip comes, or moves on before the gripper has closed."""
    gust = {"simulation__gust.vehicle": 2.0, "simulation__gust.leaf": 2.0, "simulation__gust.direction": direction}
    recording, mission = flown(scenario="paper", **gust)
    summary = recording.summary
    assert summary is not None and summary["collisions"] == 0
    assert "the gripper does not hold" not in mission.outcome[1] and told_truly(summary) is not False


def slipped_and_noticed(scenario: str = "paper", **keys: float) -> tuple[float, float, Recording]:
    """When the gripper slipped, and when the vehicle left [s]."""
    recording, mission = flown(scenario=scenario, **keys)
    assert mission.outcome == (False, "the gripper does not hold the leaf")
    truth = recording["truth"]
    slipped = float(truth.time[int(np.argmax(truth["grip_slips"] > 0))])
    return slipped, float(recording["mission"].time[phases(recording).index("retreat")]), recording


@pytest.mark.parametrize(("scenario", "force", "friction"), [("paper", 5.0, 0.3), ("pull", 4.0, 2.0)])
def test_a_gripper_that_slips_is_noticed_before_its_tip_strikes_the_leaf(
    scenario: str, force: float, friction: float
) -> None:
    """A leaf with much friction takes the push of a loose tip as it took that of a held one."""
    slipped, noticed, recording = slipped_and_noticed(
        scenario, simulation__gripper_force=force, simulation__door_friction=friction
    )
    assert slipped < noticed < slipped + 0.3
    summary, weight = recording.summary, Model(scenario).vehicle.weight
    assert summary is not None and summary["collisions"] == 0 and summary["max_push_force_n"] < 1.1 * weight
    assert "the gripper slipped" in summary["true_causes"]


@pytest.mark.slow
@pytest.mark.parametrize(("force", "friction", "wind"), [(4.0, 0.0, 1.0), (6.0, 0.3, 0.0), (5.0, 0.5, 0.0)])
def test_a_gripper_that_slips_is_noticed_on_any_door(force: float, friction: float, wind: float) -> None:
    slipped, noticed, recording = slipped_and_noticed(
        simulation__gripper_force=force, simulation__door_friction=friction, simulation__gust__vehicle=wind,
        simulation__gust__direction=2.0,
    )  # fmt: skip
    assert slipped < noticed < slipped + 1.0
    assert recording.summary is not None and recording.summary["collisions"] == 0


@pytest.mark.slow
@pytest.mark.parametrize("wind", [0.0, 1.0])
@pytest.mark.parametrize(("friction", "damping"), [(0.0, 0.0), (2.0, 2.0)])
def test_a_gripper_that_never_closes_is_noticed_on_any_door(wind: float, friction: float, damping: float) -> None:
    recording, mission = flown(
        scenario="paper", simulation__gripper_force=0.0, simulation__door_friction=friction,
        simulation__door_damping=damping, simulation__gust__vehicle=wind, simulation__gust__direction=2.5,
    )  # fmt: skip
    assert mission.outcome == (False, "the gripper does not hold the leaf")
    assert recording.summary is not None and recording.summary["outcome"] == "given up"


@pytest.mark.slow
@pytest.mark.parametrize(("wind", "from_where"), [(1.0, -1.6), (1.5, -1.0)])
def test_a_door_that_wind_blows_past_the_goal_is_brought_back(wind: float, from_where: float) -> None:
    """Closer and friction are as strong as each other, and the wind opens it."""
    gust = {"simulation__gust.vehicle": wind, "simulation__gust.leaf": wind, "simulation__gust.direction": from_where}
    recording, mission = flown(scenario="paper", simulation__door_friction=1.2, simulation__door_stiffness=1.3, **gust)
    assert mission.outcome == (True, "")
    summary = recording.summary
    assert summary is not None and summary["collisions"] == 0 and summary["attempts"] == 1
    assert abs(summary["final_door_angle_deg"] - 20.0) < 2.0
