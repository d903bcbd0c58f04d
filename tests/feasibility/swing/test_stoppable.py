"""Whether a leaf that is pushed can be stopped: friction, closer, weight and the joint's end decide."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from urdf_variants import DOOR, write_edited

from doorman.control.way_out import way_out
from doorman.feasibility import check
from doorman.feasibility.swing.flight import stopping_findings
from doorman.feasibility.swing.geometry import force_needed
from doorman.feasibility.swing.rehearsal import least_resistance, rehearse, resistance
from doorman.mission.settled import settled
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.scenario.sections.estimation import USUAL_HINGE
from doorman.simulation.simulator import Simulator

PLUMB = '<origin xyz="0 0 0.4" rpy="0 0 0"/>\n    <parent'
FLAP = {"contact.kind": "push", "contact.frame": None, "contact.side": "pull", "contact.distance_from_hinge": 0.5,
        "start.opening": 0.5}  # fmt: skip


def leaning(folder: Path, lean: str, friction: float) -> Model:
    urdf = write_edited(folder / "door.urdf", DOOR, (PLUMB, PLUMB.replace("0 0 0", lean)))
    keys = {"door.urdf": str(urdf), "door.friction": friction, "simulation.door_friction": friction}
    return Model(Scenario.load("push", keys))


@pytest.mark.parametrize(
    ("lean", "friction", "stops"),
    [("0.02 0 0", 0.5, False), ("0.02 0 0", 3.0, True), ("0 -0.02 0", 0.5, True), ("0 0 0", 0.5, True)],
)
def test_a_door_whose_weight_drives_it_on_is_refused(lean: str, friction: float, stops: bool, tmp_path: Path) -> None:
    """11 kg, 0.6 m from a hinge that leans by 0.02 rad: 1.3 N m, which opens the door or shuts it."""
    model = leaning(tmp_path, lean, friction)
    (finding,) = stopping_findings(model)
    assert (finding.severity.value == "ok") is stops, finding.message
    most = 11.0 * 9.81 * 0.6 * math.sin(0.02)
    least = {"0.02 0 0": -math.sin(math.radians(70.0)), "0 -0.02 0": math.cos(math.radians(70.0)), "0 0 0": 0.0}
    assert least_resistance(model) == pytest.approx(friction + least[lean] * most, abs=0.02)


def test_the_plants_friction_decides_and_an_unknown_one_is_asked_for() -> None:
    (flown,) = stopping_findings(Model(Scenario.load("push", {"simulation.door_friction": 0.0})))
    assert flown.severity.value == "error"
    (unknown,) = stopping_findings(Model(Scenario.load("push", {"simulation.door_friction": None})))
    assert unknown.severity.value == "warning" and "door.friction" in unknown.advice
    (told,) = stopping_findings(Model(Scenario.load("push", {"door.friction": 0.5})))
    assert told.severity.value == "ok"


def test_plant_and_check_have_one_friction_where_nobody_names_one() -> None:
    model = Model(Scenario.load("push", {"simulation.door_friction": None}))
    assert 0.0 < model.friction.least < model.friction.expected < model.friction.largest
    plant = Simulator(model, 0.001).plant
    assert plant.engine_model.dof_frictionloss[plant.hinge_velocity] == pytest.approx(model.friction.expected)
    assert resistance(model) == pytest.approx(model.friction.expected)
    assert least_resistance(model) == pytest.approx(model.friction.least)
    named = Model(Scenario.load("push", {"simulation.door_friction": model.friction.largest}))
    assert force_needed(named) < force_needed(model), "it may be the largest"


def test_a_grip_meets_the_same_friction_as_a_push() -> None:
    """How the tip holds a leaf changes nothing of its hinge."""
    pushed, gripped = (Model(Scenario.load("push", {"simulation.door_friction": None, "contact.kind": kind})) for kind in
                       ("push", "grip"))  # fmt: skip
    assert gripped.friction == pushed.friction and not gripped.friction.known


@pytest.mark.slow
def test_a_light_leaf_of_unknown_friction_is_flown_with_the_least_and_the_largest() -> None:
    """4 kg: with 0.2 N m the leaf would be thrown, or it is stopped; either way it is known from a flight."""
    model = Model(Scenario.load("push", {"simulation.door_friction": None, "door.mass": 4.0}))
    report = settled(model, check(model))
    finding = report["flight"]
    assert "of friction" in finding.message
    assert finding.ok or "door.friction" in finding.advice


@pytest.mark.parametrize(("goal", "stops"), [(0.0, True), (0.1, False)])
def test_a_flap_that_falls_shut_is_pushed_to_its_stop_alone(goal: float, stops: bool) -> None:
    keys: dict[str, Any] = {**FLAP, "goal.opening": goal, "door.friction": 0.2}
    (finding,) = stopping_findings(Model(Scenario.load("shipped:hatch", keys)))
    assert (finding.severity.value == "ok") is stops, finding.message


def test_a_leaf_that_stands_ajar_has_the_friction_for_it() -> None:
    model = Model(Scenario.load("shipped:hatch", {**FLAP, "goal.opening": 0.1}))
    weight = abs(model.door.weight_torque(model.travel.start))
    assert weight > model.hinge_scale * USUAL_HINGE["friction"][0]
    assert 0.0 < least_resistance(model) < 0.5 * weight


@pytest.mark.parametrize("degrees", [95, 112])
def test_the_way_out_of_a_door_open_beyond_a_right_angle_leads_away_from_its_leaf(degrees: int) -> None:
    model = Model(Scenario.load("push", {"goal.opening": math.radians(degrees)}))
    assert model.surroundings == "corners"
    door, state = model.door, model.goal_state
    place = model.coupling.vehicle_position(state[:3], float(state[3]), state[5:])
    targets = way_out(model, place, float(state[3]))
    steps = np.diff(np.array([place, *targets]), axis=0)
    assert door.normal(float(state[3])) @ steps[0] < -0.05, "first away from the leaf"
    inside = [door.in_doorway(target - door.hinge_position)[1] for target in targets]
    assert min(inside) > model.vehicle.radius and max(inside) < door.width - model.vehicle.radius
    assert targets[-1] @ door.into < place @ door.into - 1.0


@pytest.mark.parametrize(("degrees", "share"), [(70.0, 1.0), (105.0, 1.0), (35.0, 0.5), (14.0, 0.2)])
def test_an_arm_that_pushes_moves_by_as_much_as_the_leaf_turns(degrees: float, share: float) -> None:
    model = Model(Scenario.load("push", {"goal.opening": math.radians(degrees)}))
    moved = model.goal_arm - model.start_arm
    whole = np.array([0.0, math.pi / 2 - 1.0, 0.6 - math.pi / 2, 0.4])
    np.testing.assert_allclose(moved, share * whole, atol=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("mass", "friction"), [(11.0, 0.5), (30.0, 0.3)])
def test_a_heavy_leaf_with_little_friction_does_not_pass_the_goal(mass: float, friction: float) -> None:
    """0.3 N m stop 14 kg m² from 0.11 rad/s on 16°."""
    model = Model(Scenario.load("push", {"door.mass": mass, "door.friction": friction}))
    off = np.degrees(rehearse(model).states[:, 3] - model.goal_angle)
    assert off.min() > -1.2 and off[-1] < 2.0
