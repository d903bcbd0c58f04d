"""The finding about proposed postures: their values in the scenario's own words, how near the limits are, and what is missing."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from urdf_variants import write_arm, write_arm_of, write_door

from doorman.feasibility import Severity
from doorman.feasibility.swing.postures import postures_finding, unusual_postures
from doorman.model import Model
from doorman.scenario import Scenario


def model_of(**overrides: object) -> Model:
    return Model(Scenario.load("paper", {key.replace("__", "."): value for key, value in overrides.items()}))


def room(model: Model) -> float:
    """Distance from the nearest constraint beyond the margin [m]."""
    states = np.array([model.start_state, model.goal_state])
    return -float(model.constraints_along(states).max()) - model.scenario.planner.margin


@pytest.mark.parametrize("joints", [None, *(pytest.param(joints, marks=pytest.mark.slow) for joints in (3, 5))])
def test_every_proposed_key_is_named_as_toml(tmp_path: Path, joints: int | None) -> None:
    urdf = {} if joints is None else {"vehicle__urdf": str(write_arm_of(tmp_path / "arm.urdf", joints))}
    model = model_of(goal__door_angle=0.7, start__attitude=[0.0, 0.0, 0.0], **urdf)
    finding = postures_finding(model)
    assert finding.ok and finding.value == pytest.approx(room(model))
    said = dict(re.findall(r"((?:start|goal)\.\w+) = (\[.*?\])", finding.message))
    assert set(said) == {"start.arm", "goal.attitude", "goal.arm"}
    values = {key: tuple(tomllib.loads(f"value = {text}")["value"]) for key, text in said.items()}
    assert values == model.proposed
    assert f"{1e2 * room(model):.1f} cm" in finding.message


def test_only_what_is_not_the_papers_is_unusual(tmp_path: Path) -> None:
    assert unusual_postures(model_of()) == ""
    assert unusual_postures(model_of(goal__arm=[0.0, 1.2, -1.2, 0.0])) == ""
    assert unusual_postures(model_of(goal__door_angle=0.3)).startswith("goal.attitude = [0.0, 0.0, -1.27")
    arm = str(write_arm_of(tmp_path / "arm.urdf", 5))
    assert [word for word in unusual_postures(model_of(vehicle__urdf=arm)).split() if "arm" in word] == [
        "start.arm",
        "goal.arm",
    ]


@pytest.mark.parametrize(("width", "contact", "rod"), [(0.84, 0.42, 0.25), (1.2, 0.7, 0.16)])
def test_what_is_missing_is_told_and_helps(tmp_path: Path, width: float, contact: float, rod: float) -> None:
    """A disc smaller by what the widest postures lack leaves room."""
    task = {
        "door__urdf": str(write_door(tmp_path / "door.urdf", width=width)),
        "vehicle__urdf": str(write_arm(tmp_path / "arm.urdf", rod=rod)),
        "contact__distance_from_hinge": contact,
    }
    model = model_of(**task)
    finding = postures_finding(model)
    assert finding.severity is Severity.ERROR
    assert finding.value == pytest.approx(room(model)) and finding.value < 0.0
    lacks = {name: float(cm) for name, cm in re.findall(r"'([\w ]+)' lacks ([\d.]+) cm", finding.message)}
    assert lacks and set(lacks) <= set(model.constraint_names)
    assert max(lacks.values()) == pytest.approx(-1e2 * finding.value, abs=0.06)
    assert "vehicle.radius" in finding.advice
    smaller = model.vehicle.radius + finding.value - 2e-3
    assert postures_finding(model_of(**task, vehicle__radius=smaller)).ok


def test_a_given_posture_that_leaves_no_room_is_named() -> None:
    finding = postures_finding(model_of(goal__door_angle=0.785, goal__attitude=[0.0, 0.0, 1.5], goal__arm=[0.0] * 4))
    assert finding.ok, "the start is open, and keeps all limits"
    finding = postures_finding(model_of(goal__door_angle=0.785, goal__arm=[0.0, 0.0, 1.2, 0.0]))
    assert finding.severity is Severity.ERROR
    assert "goal.arm" in finding.advice and "start" not in finding.advice
