"""What follows where the door stands at its goal."""

from __future__ import annotations

import numpy as np

from doorman import Scenario, simulate


def test_a_tip_that_is_to_stay_holds_the_door() -> None:
    task = {"mission.then": "stay", "mission.start": "contact", "goal.door_angle": 1.2, "goal.attitude": None}
    recording = simulate(Scenario.load("shipped:paper", task), 15.0)
    states = recording["mission"]["state"].tolist()
    assert "release" not in states and "done" in states
    assert recording["truth"]["touching"][-1] and recording["command"]["grip"][-1]
    assert abs(np.degrees(recording["truth"]["door_angle"][-1] - 1.2)) < 1.5
