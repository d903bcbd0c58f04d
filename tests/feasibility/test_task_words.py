"""The task in words, with its forces by hand."""

from __future__ import annotations

import math

import pytest

from doorman.feasibility.swing.rehearsal import DURATION
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
        ("shipped:drawer", "pull open, slide, 0.00 m to 0.30 m of 0.35 m, "),
        ("shipped:sliding", "push open, slide, 0.00 m to 0.60 m of 1.00 m, "),
        ("shipped:hatch", "pull open, hinge at the top, 0° to 40° of 80°, "),
    ],
)
def test_the_task_is_said_in_words(source: str, begins: str) -> None:
    assert task_finding(Model(source)).message.startswith(begins)


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
    finding = task_finding(model)
    moving = 0.6 + 0.4 * 1.0 / DURATION + 0.2
    torque = moving + (1.5 * 1.0 + 0.8 if goal == "opening" else -0.8)
    assert finding.value == pytest.approx(max(torque, 0.0) / 0.78, abs=1e-3)
    assert finding.limit == pytest.approx(model.vehicle.mass * 9.81 * math.tan(0.25), rel=1e-3)


def test_what_a_slide_needs_at_the_handle() -> None:
    hinge = {
        "door.friction": 2.0,
        "door.damping": 6.0,
        "door.stiffness": 4.0,
        "door.preload": 0.5,
        "door.stiction": 0.2,
    }
    model = Model(Scenario.load("shipped:drawer", hinge))
    assert task_finding(model).value == pytest.approx(2.0 + 6.0 * 0.3 / DURATION + 4.0 * 0.3 + 0.5 + 0.2, abs=1e-2)


def test_what_a_hatch_needs_at_the_handle() -> None:
    """Its weight of 1.2 kg at the goal, 0.35 m along the leaf and 8 mm behind its face, on a lever of 0.62 m."""
    model = Model("shipped:hatch")
    turned = math.radians(40.0)
    torque = 1.2 * 9.81 * (0.35 * math.sin(turned) - 0.008 * math.cos(turned))
    assert task_finding(model).value == pytest.approx(torque / 0.62, rel=1e-3)
