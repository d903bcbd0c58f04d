"""The whole-body push as a task like the standard ones: the planner's own expressions, and its numbers as node parameters."""

from __future__ import annotations

from typing import Any

import numpy as np

import doorman
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.planning.hinge import Hinge
from doorman.planning.whole_body.rows import constraints, residuals
from doorman.planning.whole_body.task import WholeBodyTask
from suite.standard.task import Array, Case, StandardTask, arrays_of, discrete_step, rows_and_residuals

RESISTANCE = 0.8
"""Of the hinge that the push works against [N m]."""


def push_planner() -> doorman.Planner:
    """The scenario's planner, with the hinge of the comparison."""
    planner = doorman.Planner(doorman.Scenario.load("push"))
    planner.update_door(friction=0.0, disturbance=-RESISTANCE)
    return planner


def push_task(planner: doorman.Planner) -> StandardTask:
    """The planner's problem."""
    model, planning = planner.model, planner.planning
    problem, (pattern, _) = planning.problem(), ArmPattern.of(model.vehicle.arm)
    symbols = WholeBodyTask(pattern, model.vehicle.point_names, planning.numbers)
    x, u, q = symbols.state, symbols.inputs, symbols.parameters
    rows, terms = constraints(symbols, model.kinds), residuals(symbols, model.kinds)
    functions = {
        "step": discrete_step(x, u, q, symbols.next_state),
        **rows_and_residuals(x, u, q, problem.time_step, rows, problem.cost, terms),
    }
    return StandardTask(
        "push", "whole-body push", problem.horizon, problem.time_step, problem.nx, problem.nu, q.numel(), functions,
        *arrays_of(problem.bounds), push_case(planner, np.array(planner.start_state)),
    )  # fmt: skip


def push_case(planner: doorman.Planner, state: Array) -> Case:
    """A state, the numbers that the planner fits to it, and the guess of a cold plan: the state held, hover inputs."""
    planning, horizon = planner.planning, planner.settings.horizon_steps
    hinge = Hinge.of(planner.model.door)._replace(friction=0.0, disturbance=-RESISTANCE)
    numbers: Any = planning.fitted(hinge, planner.margin, state)
    return Case(
        state, np.tile(numbers.vector, (horizon + 1, 1)), np.tile(state, (horizon + 1, 1)),
        np.tile(planning.hover_input, (horizon, 1)),
    )  # fmt: skip
