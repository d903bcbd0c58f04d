"""Numbers of the estimate at the leaf, by the names that `LeafMotion` knows them by: a new door compiles nothing."""

from __future__ import annotations

import itertools
import math

import numpy as np

from doorman.arrays import Array
from doorman.estimation.leaf.constants import CONSTANTS
from doorman.estimation.leaf.kernels.report import LeafState
from doorman.kinematics.numbers import Numbers
from doorman.model import Model
from doorman.scenario import EstimationSection
from doorman.scenario.sized import starts_tied

STATES = {name: LeafState.dtype[name].itemsize // 8 for name in LeafState.dtype.names or ()}
"""Parts of the state in their order, and how many numbers each has; see `LeafMotion`."""
_ENDS = dict(zip(STATES, itertools.accumulate(STATES.values()), strict=True))
PLACES = {name: slice(_ENDS[name] - size, _ENDS[name]) for name, size in STATES.items()}
SIZE = sum(STATES.values())

LEAST_NOISE = 1e-4
"""Least noise of a pose's position: the filter must stay able to learn [m]."""

TUNED = (
    "sensor.pose", "sensor.tip_force", *CONSTANTS,
    *(f"noise.{key}" for key, _ in EstimationSection().noise),
)  # fmt: skip
"""Names of what is no fact of vehicle or door: constants, and keys of `[estimation]`; the sensors' are of the flight."""

_ON_LEVER = 0.05
"""Deviation of the tip's speed in the face where it holds a lever, which turns on the leaf: 0.12 m long, by 0.4 rad/s [m/s]."""


def leaf_numbers(model: Model, pose_deviation: float) -> Numbers:
    """Numbers of a scenario: constants, those of `[estimation]`, and what follows from vehicle and door."""
    settings = model.scenario.estimation
    tuned = {name: value * model.ratios.get(unit, 1.0) for name, (value, unit) in CONSTANTS.items()}
    tuned |= {f"noise.{key}": value for key, value in settings.noise}
    if model.scenario.door.beside and not model.door.in_plane:
        tuned["contact.slip_rate"] = _ON_LEVER * model.scale.speed
    if model.door.at_its_stop(model.start_angle):
        tuned["start.joint"] = tuned["start.stop"]
    if model.scenario.contact.kind == "push":
        turned = 0.0 if model.door.slides else model.coupling.lever_length * settings.door_yaw_deviation
        tuned["start.face"] = max(math.hypot(settings.door_place_deviation, turned), tuned["start.face"])
    if starts_tied(model.scenario):  # no motion tells lift from what a held tip bears: thrust is as commanded
        tuned["start.lift"] = tuned["noise.lift"]
    # an offset of a sensor in the tip is learnt in free flight
    offset = settings.tip_force_offset if model.scenario.mission.start == "contact" else 0.0
    bodies = {} if model.vehicle.bodies.balanced else model.vehicle.bodies.numbers()
    return model.reduced.numbers.and_also({
        **bodies,
        "reference.sense": math.copysign(1.0, model.goal_state[3] - model.start_state[3]),
        "sensor.pose": max(pose_deviation, LEAST_NOISE),
        "sensor.tip_force": math.hypot(tuned["contact.swings"], settings.tip_force_noise, offset),
        "sensor.leaf": 1.0,  # readings come with their own
        "contact.borne": np.zeros(2),  # by a lever that the tip holds down, along leaf and hinge [N]
        "contact.way": 1.0,  # a leaf that stands is to go on, or back: -1
        "frame.normal": np.zeros(3),  # into what a tip feels for
        **tuned,
    })  # fmt: skip


def part(states: Array, name: str) -> Array:
    """A part of many states, shape (..., n): its numbers, or the one that it has."""
    found = states[..., PLACES[name]]
    return found if STATES[name] > 1 else found[..., 0]


def first_state(model: Model, numbers: Numbers, position: Array) -> tuple[LeafState, LeafState]:
    """What is believed before the first touch, and its deviations."""
    mean, deviations = LeafState(), LeafState()
    mean.position, mean.joint = position, model.start_state[3]
    mean.resistance, mean.log_inertia = numbers.one("start.resistance"), math.log(model.door.inertia)
    for name in STATES:
        setattr(deviations, name, numbers.one("sensor.pose" if name == "position" else f"start.{name}"))
    deviations.wind[2] = numbers.one("start.draught")
    return mean, deviations
