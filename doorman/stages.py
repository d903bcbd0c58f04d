"""Steps of a task, each a model of its own: the lever is turned and held, then the leaf is moved by it.

A step has one joint that moves. The others stand where the steps before have left them, and move in the simulated plant alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from doorman.arrays import Array
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.kinematics.doors.door import Door
from doorman.model import Model
from doorman.scenario import BesideSection, FirstSection, Scenario, SimulationSection, StartSection

_TRUE = ("damping", "friction", "stiffness", "preload")
"""Torques of a joint that the plant may have otherwise than the planner believes."""


@dataclass(frozen=True, eq=False)
class Handover:
    """What a step leaves to the next one, whose tip is where this one has it."""

    tip_force: Array
    """Force of the tip on what it holds, shape (3,), world frame [N]."""
    of_the_air: Mapping[str, tuple[Array | float, Array | float]]
    """`wind` on the vehicle, shape (3,), world frame [N], and `lift` of the rotors beyond their command, as a share of that:
    each with its deviation."""
    loop: AttitudeLoop | None
    """The attitude loop that was measured in hover,"""
    rates_late: float
    """and how much later than the poses' attitudes the body rates come [s]."""


def stages(scenario: Scenario) -> tuple[Model, ...]:
    """Models of all steps, in their order; the last is the task itself."""
    if not scenario.first:
        return (Model(scenario),)
    leaf = Door(scenario.door_urdf, scenario.door)
    beside = {}
    for step in scenario.first:  # a lever before it is turned
        closed, own = step.door.closed or 0.0, _torques(step.true, step.door)
        beside[step.door.hinge] = BesideSection(joint=step.door.hinge, value=closed, closed=closed, **own)
    own = _torques(scenario.simulation, scenario.door, "door_")
    beside[scenario.door.hinge] = BesideSection(joint=scenario.door.hinge, value=leaf.closed, closed=leaf.closed, **own)
    made: list[Model] = []
    for step in scenario.first:
        model = Model(_step(scenario, step, beside, made))
        made.append(model)
        turned = {"value": model.door.joint_value(model.goal_angle), "closed": model.door.closed}
        beside[step.door.hinge] = beside[step.door.hinge].model_copy(update=turned)
    last = {
        "door": scenario.door.model_copy(update={"beside": _others(beside, scenario.door.hinge)}),
        **_after(scenario, scenario.start, made),
    }
    return (*made, Model(scenario.model_copy(update={"first": (), **last})))


def _step(scenario: Scenario, step: FirstSection, beside: dict[str, BesideSection], made: list[Model]) -> Scenario:
    """A step's own task; the tip stays on the handle at its end."""
    whole, named = scenario.door, step.door
    place = {key: getattr(whole, key) for key in ("urdf", "position", "yaw", "latch")}
    others = _others(beside, named.hinge, first=whole.hinge)
    after = _after(scenario, StartSection(), made)
    start = scenario.mission.start if not made else "contact"
    mission = scenario.mission.model_copy(update={"start": start, "then": "stay"})
    return scenario.model_copy(update={
        "first": (), "door": named.model_copy(update={**place, "beside": others}), "contact": step.contact, "goal": step.goal,
        "start": StartSection(), "simulation": _simulated(scenario, step), **after, "mission": mission,
    })  # fmt: skip


def _after(scenario: Scenario, start: StartSection, made: list[Model]) -> dict[str, object]:
    """What is otherwise after another step: the tip is on the handle, and the arm as that has left it."""
    if not made:
        return {}
    planner = scenario.planner
    return {
        "mission": scenario.mission.model_copy(update={"start": "contact"}),
        "start": start.model_copy(update={"arm": tuple(made[-1].goal_arm.tolist())}),
        "planner": planner if planner.model is not None else planner.model_copy(update={"model": "whole_body"}),
    }


def _others(beside: dict[str, BesideSection], own: str, first: str = "") -> tuple[BesideSection, ...]:
    """All joints but the one that a step moves, the leaf's first."""
    return tuple(sorted((each for name, each in beside.items() if name != own), key=lambda each: each.joint != first))


def _torques(true: Any, planned: Any, prefix: str = "") -> dict[str, float]:
    """Torques of the plant's joint, as far as the file names them."""
    found = {name: getattr(planned, name) for name in _TRUE}
    found |= {name: value for name in _TRUE if (value := getattr(true, prefix + name)) is not None}
    return {name: value for name, value in found.items() if value is not None}


def _simulated(scenario: Scenario, step: FirstSection) -> SimulationSection:
    """The plant of a step: of the door's keys, only where it stands is that of the whole task."""
    own, default = scenario.simulation, SimulationSection()
    values = {key: value for key, value in default if key.startswith("door_") and key not in _PLACE}
    return own.model_copy(update={**values, **{f"door_{name}": getattr(step.true, name) for name in _TRUE}})


_PLACE = ("door_offset", "door_yaw", "door_sensor")
