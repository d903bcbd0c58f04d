"""Door problems of all kinds, each with start states of all kinds, and their solvers; built once in a run."""

from __future__ import annotations

import functools
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from interior_point import InteriorPointReference
from urdf_variants import write_arm, write_arm_of, write_door

from doorman.model import Model
from doorman.planning.planner import Planner
from doorman.scenario import Scenario

COARSE = {"planner.time_step": 0.05, "planner.horizon_steps": 20}
KINDS = ("scenario", "moving", "thrown", "active", "violating", "late")
"""Start states: see `start_state`."""


@dataclass(frozen=True)
class DoorTask:
    """What differs from the paper's task."""

    overrides: dict[str, Any]
    door: dict[str, float] = field(default_factory=dict)
    rod: float | None = None
    joints: int | None = None


TASKS = {
    "paper": DoorTask({"planner.margin": 0.0}),
    "margin": DoorTask({"planner.margin": 0.02}),
    "coarse": DoorTask({"planner.margin": 0.0, **COARSE}),
    "tight": DoorTask(
        {
            "planner.margin": 0.01, "limits.tilt": 0.25, "limits.body_rates": [0.5, 0.35, 0.6],
            "limits.joint_rates": 0.3, "planner.horizon_steps": 30,
        }
    ),
    "slow": DoorTask(
        {
            "planner.margin": 0.0, "limits.body_rates": [0.6, 0.5, 0.45], "limits.joint_rates": 0.15,
            **COARSE,
        }
    ),
    "heavy": DoorTask(
        {"planner.margin": 0.02, "contact.distance_from_hinge": 0.9},
        door={"width": 1.5, "mass": 20.0, "damping": 0.8, "friction": 0.8},
    ),
    "closer": DoorTask(
        {
            "planner.margin": 0.0, "contact.distance_from_hinge": 0.56, "contact.height": 0.6,
            "door.stiffness": 2.0, "door.rest_angle": 1.2,
        },
        door={"width": 1.1, "mass": 6.0, "damping": 0.2},
    ),
    "rod": DoorTask(
        {"planner.margin": 0.02, "contact.distance_from_hinge": 0.8, **COARSE},
        door={"width": 1.3, "mass": 15.0, "friction": 0.4},
        rod=0.33,
    ),
    "seven joints": DoorTask({"planner.margin": 0.0, **COARSE}, joints=7),
}  # fmt: skip

CASES = [
    ("paper", False), ("paper", True), ("tight", True), ("heavy", False), ("closer", True), ("rod", False), ("slow", True),
    ("seven joints", True),
]  # fmt: skip
"""Tasks without and with `[limits]`; each number of joints and each kind of bounds is a set of kernels to compile."""


@functools.cache
def model_of(name: str, limits: bool = False) -> Model:
    """Model of a task."""
    task = TASKS[name]
    overrides: dict[str, Any] = {**task.overrides, "limits.enabled": limits}
    with tempfile.TemporaryDirectory() as folder:
        if task.door:
            overrides["door.urdf"] = str(write_door(Path(folder, "door.urdf"), **task.door))
        if task.rod is not None:
            overrides["vehicle.urdf"] = str(write_arm(Path(folder, "vehicle.urdf"), rod=task.rod))
        if task.joints is not None:
            overrides["vehicle.urdf"] = str(write_arm_of(Path(folder, "vehicle.urdf"), task.joints))
            overrides |= {"planner.weights": {}, "start.arm": [0.0] * task.joints, "goal.arm": [0.0] * task.joints}
        return Model(Scenario.load("paper", overrides))


@functools.cache
def planner_of(name: str, limits: bool = False) -> Planner:
    """Planner of a task."""
    return Planner(model_of(name, limits))


@functools.cache
def reference_of(name: str, limits: bool = False) -> InteriorPointReference:
    """Independent solver of a task."""
    return InteriorPointReference(model_of(name, limits))


@functools.cache
def start_state(name: str, kind: str, limits: bool = False) -> np.ndarray:
    """Start state of a task.

    scenario: at rest as in the scenario; moving: on the way, posture and attitude off; thrown: the same with larger errors;
    active: the node of the scenario's optimum that is nearest to a constraint; violating: that one pushed 2 cm further
    along the constraint's gradient; late: the end of the scenario's optimum, a little off.
    """
    model = model_of(name, limits)
    rng = np.random.default_rng(7 + KINDS.index(kind))
    spread = np.array([0.1, 0.1, 0.3, 0.3, 0.3, *[0.15] * model.n_arm]) * rng.uniform(-1.0, 1.0, model.nx)
    way = np.array([0.0, 0.0, -0.3, -0.35, -0.3, *[0.0] * model.n_arm])
    if kind == "scenario":
        return model.start_state
    if kind in ("moving", "thrown"):
        return model.start_state + way + (0.5 if kind == "moving" else 1.3) * spread
    states = planner_of(name, limits).plan(model.start_state).states
    if kind == "late":
        return states[-1] + 0.1 * spread
    h = model.constraints_along(states)
    node = 1 + int(h[1:].max(axis=1).argmax())
    if kind == "active":
        return states[node]
    gradient = model.constraint_jacobian(states[node])[h[node].argmax()]
    return states[node] + 0.02 * gradient / (gradient @ gradient)
