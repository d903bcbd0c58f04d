"""Missions whose tip touches the frame before it pushes the door: where that stands, and how far it was ajar."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hands import aborted_in, flown, phases

from doorman.control.estimation.replay import replay_leaf
from doorman.mission import Mission, Phase

FEELS: dict[str, Any] = {"mission__measures": ("poses", "attitude", "frame")}
ELSEWHERE: dict[str, Any] = {
    "simulation__door_offset": [0.01, 0.02, 0.0],
    "simulation__door_yaw": -0.03,
    "simulation__door_ajar": 0.04,
}
"""Each of yaw and place along the wall alone moves the end by 2 degrees, and the ajar leaf too."""


@pytest.mark.slow
@pytest.mark.parametrize("scenario", ["push", "push_left"])
def test_a_door_that_stands_elsewhere_and_ajar_ends_at_the_goal(scenario: str) -> None:
    recording, mission = flown(scenario=scenario, **FEELS, **ELSEWHERE)
    assert mission.outcome == (True, "")
    assert phases(recording)[:6] == ["hover", "touch_frame", "hover", "approach", "touch", "open"]
    summary = recording.summary
    assert summary is not None and summary["attempts"] == 1
    assert summary["collisions"] == 0 and summary["min_clearance_m"] > 0.0
    assert recording["truth"]["collisions"].any(), "the tip was on the wall"
    assert abs(summary["final_error"]) < 0.7
    for name in ("door_x", "door_y", "door_yaw", "door_angle"):
        found = summary["estimates"][name]
        assert abs(found["value"] - found["true"]) < 3.0 * found["deviation"], (name, found)
    assert summary["estimates"]["door_angle"]["deviation"] < math.radians(0.5)


def test_a_frame_that_is_not_there_ends_the_mission() -> None:
    recording, mission = flown(**FEELS, simulation__door_offset=[0.2, 0.0, 0.0])
    opened, reason = mission.outcome
    assert not opened and reason.startswith("the frame is not where the map has it")
    assert phases(recording) == ["hover", "touch_frame", "retreat", "done", "end"]
    summary = recording.summary
    assert summary is not None and summary["collisions"] == 0 and not recording["truth"]["touching"].any()


FAR: dict[str, Any] = {"simulation__door_offset": [0.03, 0.0, 0.0], "simulation__door_yaw": 0.0524}
"""The wall beside the hinge is 8 cm farther away than in the map, of whose place 6 cm are 3 standard deviations."""


def test_a_frame_that_is_met_beyond_its_doubt_counts() -> None:
    recording, mission = flown(on_progress=aborted_in(Phase.APPROACH), **FEELS, **FAR)
    assert phases(recording)[:4] == ["hover", "touch_frame", "hover", "approach"]
    summary = recording.summary
    assert summary is not None and summary["collisions"] == 0
    replayed, touched = replay_leaf(recording, mission.model), recording["truth"]["collisions"] > 0
    assert touched.any() and abs(replayed.wind[:, :2, 0]).max() < 0.6, "the air is still: the wall pushes back"


def test_a_mission_that_ends_with_the_tip_on_the_frame_knows_that_it_is_not_on_the_leaf() -> None:
    aborted: list[float] = []

    def stop(mission: Mission, time: float, angle: float) -> None:
        if mission._known is not None and mission._known.stopped:
            mission.abort("the operator said so")
            aborted.append(time)

    recording, mission = flown(on_progress=stop, **FEELS, **FAR)
    assert mission.outcome == (False, "the operator said so")
    summary, ends, truth = recording.summary, recording["mission"].time[-1], recording["truth"]
    assert truth["collisions"][truth.time > aborted[0] - 0.1].any(), "the tip was on the wall"
    assert summary is not None and summary["collisions"] == 0 and ends > aborted[0] + 1.0
    angles = recording["estimate"]["state"][:, 3]
    assert abs(angles - math.pi / 2).max() < 0.05
