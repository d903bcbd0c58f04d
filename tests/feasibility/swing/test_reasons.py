"""Reasons are true: what is named as the cause is there."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from doorman.feasibility.report import Report
from doorman.feasibility.swing.flight import flight_findings
from doorman.feasibility.swing.rehearsal import Rehearsal
from doorman.model import Model
from doorman.scenario import Scenario


def advice_for(door_rate: float, **door: Any) -> str:
    """Advice for a rehearsal that ends soon after the start, inside all constraints."""
    model = Model(Scenario.load("paper", {f"door.{key}": value for key, value in door.items()}))
    states = np.tile(model.start_state, (40, 1))
    states[:, 3], states[:, 2], states[:, 4] = 1.5, 1.5 - np.pi / 2, door_rate
    inputs = np.tile(model.hover_input, (40, 1))
    rehearsal = Rehearsal(np.linspace(0.0, 12.0, 40), states, inputs, np.zeros(40), "")
    finding = Report("", tuple(flight_findings(model, rehearsal)))["goal reached"]
    assert not finding.ok
    return finding.advice


@pytest.mark.parametrize(
    ("door", "named", "absent"),
    [
        ({}, {"stands still"}, {"spring", "friction", "inertia"}),
        ({"friction": 0.4}, {"friction of 0.40 N m"}, {"spring"}),
        ({"stiffness": 2.0}, {"spring of 0.14 N m"}, {"friction"}),
        ({"stiffness": 2.0, "rest_angle": 0.2}, {"stands still"}, {"spring"}),  # that one opens
        ({"mass": 900.0}, {"432 kg m²", "lighter leaf"}, {"spring", "planner.weights"}),
    ],
)
def test_a_door_that_stands_is_held_by_what_its_hinge_has(
    door: dict[str, float], named: set[str], absent: set[str]
) -> None:
    advice = advice_for(0.0, **door)
    assert all(word in advice for word in named), advice
    assert not any(word in advice for word in absent), advice


def test_a_door_that_moves_is_not_said_to_stand() -> None:
    assert "still moves" in advice_for(-0.05)
