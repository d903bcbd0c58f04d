"""The stretch of a free time in trajectories: the last state, and the first value of the last input; see `problem.free_time`."""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.memory.parts import Trajectory
from doorman.ocp.solvers.memory.workspace import Workspace


def set_stretch(trajectory: Trajectory, stretch: float) -> None:
    """Stretch the whole of a trajectory by one factor."""
    trajectory.states[:, -1] = stretch
    trajectory.inputs[:, -1] = 1.0
    trajectory.inputs[0, -1] = stretch


def time_step_of(problem: Problem, inputs: Array) -> float:
    """Δt of a trajectory [s]."""
    return problem.time_step if problem.free_time is None else problem.time_step * float(inputs[0, -1])


def with_stretch(problem: Problem, states: Array, inputs: Array, time_step: float) -> tuple[Array, Array]:
    """States and inputs as the problem's functions take them."""
    if problem.free_time is None:
        return states, inputs
    n, stretch = problem.horizon, time_step / problem.time_step
    choices = np.ones((n, 1))
    choices[0] = stretch
    return np.hstack([states, np.full((n + 1, 1), stretch)]), np.hstack([inputs, choices])


def divide_rest(work: Workspace, shift: float) -> None:
    """Make the nominal trajectory what is left of it after `shift` steps, in as many steps as before.

    Multipliers of rows at nodes are prices by node: shorter steps have smaller ones.
    """
    nominal, n = work.nominal, work.nominal.inputs.shape[0]
    part = (n - shift) / n
    if part >= 1.0:
        return
    at = shift + part * np.arange(n + 1)
    of_input, of_state = (shift + part * (np.arange(n) + 0.5)).astype(np.int64), np.ceil(at[1:]).astype(np.int64) - 1
    stretch = max(part * nominal.inputs[0, -1], work.limits.input_lower[-1])
    nominal.states[:] = np.column_stack([np.interp(at, np.arange(n + 1), column) for column in nominal.states.T])
    nominal.inputs[:] = nominal.inputs[of_input]
    work.policy.gains[:] = work.policy.gains[of_input]
    prices = work.multipliers
    for array, source in (
        (prices.rows, of_state), (prices.states, of_state), (prices.input_rows, of_input), (prices.inputs, of_input)
    ):  # fmt: skip
        array[:] = part * array[source]
    prices.inputs[:, -1] = 0.0
    set_stretch(nominal, stretch)
