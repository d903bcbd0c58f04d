"""A tip that presses on a lever: kept there by friction, on the lever's slope, and for no step that follows."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from doorman.feasibility.pressed import hold_findings, slip_findings
from doorman.feasibility.swing.rehearsal import rehearse
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.stages import stages

PRESSED: dict[str, Any] = {"contact.kind": "push", "goal.opening": 0.7, "goal.duration": 8.0}
"""Makes `knob_valve` a valve that a tip presses open from above."""


def pressed(keys: dict[str, Any] | None = None) -> Model:
    """The pressed valve, or another one."""
    return Model(Scenario.load("knob_valve", PRESSED | (keys or {})))


def test_friction_bears_what_presses_along_the_slope() -> None:
    """By hand: a plumb force on a slope of θ needs tan θ of friction, less what the vehicle's yaw torque takes off."""
    flat = pressed()
    (found,) = slip_findings(flat)
    assert found.ok, found.message
    steep = pressed({"goal.opening": 1.39, "simulation.door_friction": 3.0})
    (found,) = slip_findings(steep)
    slope = math.acos(abs(float(steep.door.normal(steep.goal_angle)[2])))
    assert 0.6 * math.tan(slope) < found.value < math.tan(slope) and found.ok is (found.value <= 0.6)
    slippery = pressed({"simulation.door_friction": 3.0, "contact.friction": 0.2})
    (found,) = slip_findings(slippery)
    assert not found.ok and "friction" in found.advice + found.message


def test_a_lever_that_is_pressed_is_held_for_no_next_step() -> None:
    plain = Scenario.load("lever_push")
    written: dict[str, Any] = plain.first[0].model_dump(exclude_unset=True)
    pressed = written | {"contact": {"kind": "push", "frame": "lever_top"}}
    lever, leaf = stages(Scenario.load("lever_push", {"first": [pressed]}))
    (found,) = hold_findings(lever, leaf)
    assert not found.ok and "grip" in found.advice
    assert hold_findings(*stages(plain)) == []


def test_the_last_link_points_down_at_the_lever() -> None:
    """A tip whose last link lies along the lever touches it with the link."""
    model = pressed()
    for state in (model.start_state, model.goal_state):
        *_, before, tip = model.vehicle.point_positions(state[5:])
        assert float(before[2] - tip[2]) > math.sin(math.radians(25.0)) * float(np.linalg.norm(tip - before)) - 1e-9


def test_a_light_lever_is_pressed_to_its_goal() -> None:
    """The contact that plans count on is one that a step resolves: a lever of 2 g m² diverges under that of a leaf."""
    model = pressed()
    rehearsal = rehearse(model)
    assert not rehearsal.failure
    assert abs(rehearsal.final_door_angle - model.goal_angle) < math.radians(2.0)
