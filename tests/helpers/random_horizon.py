"""Workspaces full of random numbers, of problems of two sizes: what sweeps read, without anything that they might rely on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from door_tasks import model_of
from double_integrator import Variant
from numpy.typing import NDArray

from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.planning.grip.door_problem import door_problem

Array = NDArray[np.float64]

N = 6


def cart() -> Problem:
    """All kinds of rows and bounds, one integrator."""
    return Variant(force=(-0.4, 0.3), rate=(-0.2, 0.2), room=(-0.5, 0.6), boom=(-0.2, 0.3), horizon=N).problem()


def door() -> Problem:
    """Nine states, eight inputs, four integrators; rows of the states alone."""
    return replace(door_problem(model_of("paper")), horizon=N)


def random_horizon(problem: Problem, rng: np.random.Generator, defects: bool = True) -> Workspace:
    """A nominal trajectory and its linearisation; rows are violated or not."""
    work, m, nx, nu = Workspace.of(problem), problem.integrators, problem.nx, problem.nu
    s, v = nx - m, nu - m
    work.nominal.states[:], work.nominal.inputs[:] = rng.normal(size=(N + 1, nx)), rng.normal(size=(N, nu))
    jacobians = np.zeros((N, nx, nx + 1 + nu))
    jacobians[:, :s, :s] = 0.6 * rng.normal(size=(N, s, s))
    jacobians[:, :s, nx] = defects * rng.normal(size=(N, s))
    jacobians[:, :s, nx + 1 : nx + 1 + v] = rng.normal(size=(N, s, v))
    jacobians[:, s:, s:nx], jacobians[:, s:, nx + 1 + v :] = np.eye(m), problem.time_step * np.eye(m)
    work.linear.jacobians[:, :, : nx + 1 + nu] = jacobians
    work.linear.row_jacobians[:, :, :nx] = rng.normal(size=work.linear.row_jacobians[:, :, :nx].shape)
    mixed = work.linear.input_row_jacobians
    mixed[:, :, : nx + 1 + nu] = rng.normal(size=mixed[:, :, : nx + 1 + nu].shape)
    mixed[:, :, nx] = 0.0
    work.linear.end_row_jacobians[:, :nx] = rng.normal(size=work.linear.end_row_jacobians[:, :nx].shape)
    for values in (work.nominal.rows, work.nominal.input_rows, work.nominal.end_rows):
        values[:] = rng.normal(size=values.shape)
    return work


def activate(work: Workspace, problem: Problem, rng: np.random.Generator) -> None:
    """A random active set with multipliers of the right signs."""
    for name in ("rows", "input_rows", "end_rows"):
        multipliers = getattr(work.multipliers, name)
        multipliers[:] = rng.exponential(size=multipliers.shape)
        getattr(work.active, name)[:] = rng.random(multipliers.shape) < 0.5
    bounds = problem.bounds
    for name, lower, upper in (
        ("states", bounds.state_lower, bounds.state_upper), ("inputs", bounds.input_lower, bounds.input_upper)
    ):  # fmt: skip
        sides = getattr(work.active, name)
        sides[:] = rng.integers(-1, 2, sides.shape) * (np.isfinite(lower) & np.isfinite(upper))
        getattr(work.multipliers, name)[:] = sides * rng.exponential(size=sides.shape)
    count_active(work)


def count_active(work: Workspace) -> None:
    """Numbers of active rows, which sweeps keep beside the set."""
    active = work.active
    active.state_count[:] = np.abs(active.rows).sum(axis=1) + np.abs(active.states).sum(axis=1)
    active.state_count[-1] += np.abs(active.end_rows).sum()
    active.input_count[:] = np.abs(active.input_rows).sum(axis=1) + np.abs(active.inputs).sum(axis=1)


def move_inside(work: Workspace, problem: Problem, rng: np.random.Generator) -> None:
    """Rows and bounds of the nominal trajectory hold, many of them barely."""
    for values in (work.nominal.rows, work.nominal.input_rows, work.nominal.end_rows):
        values[:] = -0.1 * rng.exponential(size=values.shape)
    bounds = problem.bounds
    for values, lower, upper in (
        (work.nominal.states, bounds.state_lower, bounds.state_upper),
        (work.nominal.inputs, bounds.input_lower, bounds.input_upper),
    ):
        low, high = np.maximum(lower, -3.0), np.minimum(upper, 3.0)
        values[:] = low + (high - low) * rng.beta(0.5, 0.5, values.shape)
