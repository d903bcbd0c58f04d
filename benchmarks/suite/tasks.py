"""The tasks: the paper's door, doors drawn at random, other horizons and other arms."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

import doorman
from suite.task import Array, Task
from suite.urdfs import write_door, write_vehicle

STATE_WEIGHTS, INPUT_WEIGHTS = (5.0, 5.0, 3.0, 9.0, 8.0), (0.1, 5.0, 5.0, 13.5)
"""The paper's; joints of the arm: 0.05 for the first, 0.1 for the others, and 10 for every rate."""


def paper(**planner: Any) -> Task:
    """The paper's task with six inequalities at a node and no margin.

    Args:
        planner: Further keys of the scenario's planner, for example `horizon_steps`.
    """
    name = " ".join(["paper", *(f"{key}={value}" for key, value in planner.items())])
    return task(name, {f"planner.{key}": value for key, value in planner.items()})


def limited() -> Task:
    """The paper's task with the limits that doorman's scenarios have by default."""
    return task("paper, limited", {"limits.enabled": True})


def random_door(seed: int, folder: Path) -> Task:
    """A door drawn at random from the ranges for which doorman is meant; odd seeds have no friction.

    Args:
        seed: Of the draw.
        folder: Where its URDF goes.
    """
    rng = np.random.default_rng(seed)
    width, mass = rng.uniform(1.1, 1.5), rng.uniform(6.0, 20.0)
    overrides = {
        "door.urdf": str(write_door(folder / f"door_{seed}.urdf", width=width, mass=mass)),
        "contact.distance_from_hinge": float(rng.uniform(0.55, width - 0.5)),
        "contact.height": float(rng.uniform(0.6, 1.0)),
        "door.damping": float(rng.uniform(0.0, 0.8)),
        "door.friction": float(rng.uniform(0.0, 0.8)) * (seed % 2 == 0),
    }
    return task(f"door {seed}", overrides)


def arm(joints: int, folder: Path) -> Task:
    """The paper's door and an arm of some joints.

    Args:
        joints: 2 to 7.
        folder: Where its URDF goes.
    """
    vehicle = write_vehicle(folder / f"arm_{joints}.urdf", joints)
    overrides = {
        "vehicle.urdf": str(vehicle), "start.arm": [0.0] * joints, "goal.arm": [0.0] * joints,
    }  # fmt: skip
    return task(f"arm of {joints}", overrides)


def task(name: str, overrides: dict[str, Any]) -> Task:
    """Numbers of the paper's scenario, without margin and limits, with some keys changed.

    The weights are told to everyone, doorman included.
    """
    plain = {"planner.margin": 0.0, "limits.enabled": False, **overrides}
    model = doorman.Model(doorman.Scenario.load("paper", plain))
    n = model.n_arm
    state_weights = [*STATE_WEIGHTS, *([0.05] + [0.1] * n)[:n]]
    told = {
        **plain,
        "planner.weights.state": state_weights,
        "planner.weights.input": [*INPUT_WEIGHTS, *[10.0] * n],
    }  # fmt: skip
    door, arm_geometry, planner = model.door, model.vehicle.arm, model.scenario.planner
    return Task(
        name=name, overrides=told, horizon=planner.horizon_steps, time_step=planner.time_step, margin=planner.margin,
        mass=model.vehicle.mass, radius=model.vehicle.radius, door_width=door.width, door_inertia=door.inertia,
        damping=door.damping, friction=door.friction, friction_rate=door.friction_rate, stiffness=door.stiffness,
        rest_angle=door.rest_angle, distance_from_hinge=model.scenario.contact.distance_from_hinge,
        axes=_plain(arm_geometry.axes), links=_plain(arm_geometry.links),
        point_parents=np.array(arm_geometry.point_parents), point_offsets=_plain(arm_geometry.point_offsets),
        state_weights=np.array(state_weights), terminal_weights=np.array(state_weights),
        input_weights=np.array(told["planner.weights.input"]), start_state=_plain(model.start_state),
        goal_state=_plain(model.goal_state), hover_input=_plain(model.hover_input),
        **_limits(model),
    )  # fmt: skip


def _plain(array: Any) -> Array:
    return np.array(array, dtype=np.float64)


def _limits(model: doorman.Model) -> dict[str, Any]:
    """Bounds from scenario and URDF."""
    limits, vehicle = model.scenario.limits, model.vehicle
    states, inputs = _unbounded(model.nx), _unbounded(model.nu)
    if not limits.enabled:
        return {"state_bounds": states, "input_bounds": inputs, "least_cosine": -1.0}
    states[:, 5:] = vehicle.lower_limits, vehicle.upper_limits
    rates = vehicle.rate_limits if limits.joint_rates is None else np.full(model.n_arm, limits.joint_rates)
    largest = np.concatenate([[vehicle.max_thrust], limits.body_rates, rates])
    inputs[:] = -largest, largest
    inputs[0, 0] = 0.0
    return {"state_bounds": states, "input_bounds": inputs, "least_cosine": math.cos(limits.tilt)}


def _unbounded(size: int) -> Array:
    return np.array([[-math.inf] * size, [math.inf] * size])
