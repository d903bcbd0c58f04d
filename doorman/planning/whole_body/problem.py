"""The whole-body problem of a scenario: its expressions, bounds and cost."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from doorman.collision.rows.listed import Kinds
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.vehicles.actuation import LEVEL
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.model import Model
from doorman.ocp.problem.costs import QuadraticCost
from doorman.ocp.problem.problem import Bounds, Problem
from doorman.planning.composition import NO_EXTRAS, Extras, Made, task_problem
from doorman.planning.limits import bounds_of
from doorman.planning.whole_body.numbers import whole_body_numbers, yaw_torque

ARM_RATE = 1.5
"""Largest joint rate of a plan, of the shipped vehicle [rad/s]."""
LEAST_THRUST = 0.17
"""As a share of the weight."""
STATE_WEIGHT = 1e-6
"""Weight of every state: residuals do the rest."""
INPUT_WEIGHTS = (1e-3, 0.2, 0.2, 2.0)
"""Weights of thrust, commanded roll and pitch, and yaw torque, for the shipped vehicle: `weights.thrust` holds the thrust."""
SIDE_COST = 1e-3
"""Weight of the force to the side itself."""
ARM_COST = 1.0
"""Weight of every joint rate itself, for the shipped vehicle: `weights.arm_rate` holds the arm calm."""


def whole_body_problem(model: Model, numbers: Numbers | None = None, extras: Extras = NO_EXTRAS) -> Problem:
    """Optimal control problem of a scenario's vehicle, arm and door, from free flight to contact."""
    cost, bounds = _cost(model), _bounds(model)
    return task_problem("whole body", _whole_body, model, numbers or whole_body_numbers(model), cost, bounds, extras)


def _whole_body(pattern: ArmPattern, point_names: tuple[str, ...], numbers: Numbers, kinds: Kinds) -> Made:
    from doorman.planning.whole_body.rows import constraints, residuals  # CasADi
    from doorman.planning.whole_body.task import WholeBodyTask

    task = WholeBodyTask(pattern, point_names, numbers)
    return task, constraints(task, kinds), residuals(task, kinds)


def _bounds(model: Model) -> Bounds:
    """Bounds of `[limits]`, `control.max_tilt` and the vehicle; a calm arm and yaw torque whatever these allow."""
    vehicle, limits = model.vehicle, model.scenario.limits
    rates = np.minimum(vehicle.rate_limits, ARM_RATE * model.scale.rate)
    if limits.enabled:
        rates = np.minimum(rates, math.inf if limits.joint_rates is None else limits.joint_rates)
    largest = min(model.largest_tilt, LEVEL) if model.actuation.fully else model.largest_tilt
    return bounds_of(model, 14, LEAST_THRUST * vehicle.weight, [largest, largest, yaw_torque(model)], rates)


def _cost(model: Model) -> QuadraticCost:
    n, scale = model.n_arm, model.scale
    side = 2 if model.actuation.fully else 0
    none: Any = np.zeros(14 + n)
    hover = np.concatenate([[model.vehicle.weight], np.zeros(3 + n + side)])
    weights = np.full(14 + n, STATE_WEIGHT)
    units = np.array([scale.force, 1.0, 1.0, scale.torque, *[scale.rate] * n, *[scale.force] * side])
    inputs = np.array([*INPUT_WEIGHTS, *[ARM_COST] * n, *[SIDE_COST] * side])
    return QuadraticCost(weights, weights, inputs / units**2, none, hover)
