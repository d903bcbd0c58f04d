"""The task in words, with its forces by hand."""

from __future__ import annotations

import math

import pytest

from doorman.feasibility.rehearsal import DURATION
from doorman.feasibility.task import task_finding
from doorman.model import Model
from doorman.scenario import Scenario


@pytest.mark.parametrize(
    ("source", "begins"),
    [
        ("shipped:pull", "pull open, hinge on the left, 0° to 75° of 109°, "),
        ("shipped:close", "push shut, hinge on the left, 57° to 0° of 109°, "),
        ("shipped:paper", "push open, hinge on the right, 0° to 70° of 176°, "),
        ("shipped:push_left", "push open, hinge on the left, 0° to 70° of 176°, "),
    ],
)
def test_the_task_is_said_in_words(source: str, begins: str) -> None:
    assert task_finding(Model(source), DURATION).message.startswith(begins)


@pytest.mark.parametrize("goal", ["opening", "shutting"])
def test_what_the_hinge_needs_at_the_handle(goal: str) -> None:
    ends = (
        {"start.opening": 0.0, "goal.opening": 1.0}
        if goal == "opening"
        else {"start.opening": 1.0, "goal.opening": 0.0}
    )
    hinge = {
        "door.friction": 0.6,
        "door.damping": 0.4,
        "door.stiffness": 1.5,
        "door.preload": 0.8,
        "door.stiction": 0.2,
    }
    model = Model(Scenario.load("shipped:pull", {**ends, **hinge}))
    finding = task_finding(model, DURATION)
    moving = 0.6 + 0.4 * 1.0 / DURATION + 0.2
    torque = moving + (1.5 * 1.0 + 0.8 if goal == "opening" else -0.8)
    assert finding.value == pytest.approx(max(torque, 0.0) / 0.78, abs=1e-3)
    assert finding.limit == pytest.approx(model.vehicle.mass * 9.81 * math.tan(0.25), rel=1e-3)
