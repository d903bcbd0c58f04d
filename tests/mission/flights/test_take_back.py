"""A gripped door that is given up is taken back to where it was found, before the gripper opens."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from hands import flown, hand, phases

from doorman.mission import Mission

CLOSER = {"simulation__door_damping": 0.3, "simulation__door_friction": 0.3, "simulation__door_stiffness": 2.0}
"""Let go of half-way, it shuts with 2 N m."""
GIVES_UP: dict[str, Any] = {"mission__start": "contact", "mission__attempts": 1}


def test_a_door_that_is_given_up_is_not_flung_shut() -> None:
    recording, mission = flown(scenario="paper", **GIVES_UP, mission__time_out__open=4.0, **CLOSER)
    assert phases(recording) == ["touch", "open", "take_back", "release", "retreat", "done", "end"]
    opened, reason = mission.outcome
    assert not opened and reason.startswith("the phase open took longer than 4 s; the door stands at ")
    summary, truth = recording.summary, recording["truth"]
    assert summary is not None and summary["outcome"] == "given up" and summary["collisions"] == 0
    began, released = (recording["mission"].time[phases(recording).index(name)] for name in ("take_back", "release"))
    assert truth["door_angle"][truth.time < began][-1] < 1.0, "it was opened before"
    during = (recording["command"].time > began) & (recording["command"].time < released)
    assert recording["command"]["grip"][during].all()
    assert truth["door_angle"][truth.time < released][-1] > math.radians(88.0)
    assert truth["door_rate"].max() < 0.5 and abs(truth["door_angle"][-1] - 0.5 * math.pi) < 0.02
    goals = recording["plan"]["goal_angle"][recording["plan"].time > began]
    np.testing.assert_array_equal(goals, mission.model.start_angle)


def test_an_abort_does_not_take_the_door_back() -> None:
    """Whoever aborts wants the vehicle away from the door: also while it takes one back."""

    def abort(mission: Mission, time: float, angle: float) -> None:
        if mission.phase.value == "take_back":
            mission.abort("the operator said so")

    recording, _ = flown(scenario="paper", on_progress=abort, **GIVES_UP, mission__time_out__open=4.0, **CLOSER)
    states, times = phases(recording), recording["mission"].time
    assert states == ["touch", "open", "take_back", "release", "retreat", "done", "end"]
    assert times[3] - times[2] < 0.1 and recording.summary is not None and recording.summary["collisions"] == 0


def test_a_door_that_somebody_holds_is_let_go_where_it_is() -> None:
    holds = hand(70.0, 30.0, lambda way, rate: -100.0 * way - 60.0 * rate)
    recording, _ = flown(holds, scenario="paper", **GIVES_UP, mission__time_out__open=5.0)
    states, mission = phases(recording), recording["mission"]
    assert states == ["touch", "open", "take_back", "release", "retreat", "done", "end"]
    assert mission["message"][3].startswith("the door does not go back from ")
    assert 3.0 < mission.time[3] - mission.time[2] < 12.0
    assert recording.summary is not None and recording.summary["collisions"] == 0


def test_a_door_that_was_to_be_shut_is_let_go_where_it_is() -> None:
    recording, _ = flown(scenario="close", mission__attempts=1, mission__time_out__open=2.0)
    assert phases(recording)[-5:] == ["open", "release", "retreat", "done", "end"]
