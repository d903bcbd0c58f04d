"""The Riccati sweep with the penalties of rows, bounds, mixed and end rows, and the step along it, against one dense program."""

from __future__ import annotations

import numpy as np
import pytest
from dense_horizon import DenseHorizon
from numpy.typing import NDArray
from random_horizon import N, activate, cart, count_active, door, random_horizon

from doorman.numba_types.handles import Handle, held
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.active_set import classify
from doorman.ocp.solvers.sweeps.sweep import step_along, sweep

Array = NDArray[np.float64]

PENALTY = 40.0


@pytest.fixture(params=[cart, door])
def problem(request: pytest.FixtureRequest) -> Problem:
    return request.param()


def random_sweep(problem: Problem, rng: np.random.Generator, defects: bool = True) -> Workspace:
    work = random_horizon(problem, rng, defects)
    activate(work, problem, rng)
    return work


def swept(problem: Problem, work: Workspace, regularization: float = 0.0, last: int = N - 1) -> bool:
    return bool(sweep(Handle(problem.model), held(work), PENALTY, regularization, last))


def stepped(work: Workspace) -> bool:
    """Step of the last sweep; whether the active set flips there."""
    memory = held(work)
    step_along(memory)
    return bool(classify(memory, work.trial, PENALTY) >= 0)


@pytest.mark.parametrize("regularization", [0.0, 3.0])
def test_step_and_policy_are_the_minimum_of_the_dense_program(
    problem: Problem, regularization: float, rng: np.random.Generator
) -> None:
    work, nx = random_sweep(problem, rng), problem.nx
    for first in range(N):
        dense = DenseHorizon(work, first)
        dense.penalize_active(PENALTY)
        dense.regularize(regularization)
        assert swept(problem, work, regularization)
        offset = dense.states_and_inputs(dense.solve(np.zeros(nx)))[1][0]
        np.testing.assert_allclose(work.policy.gains[first, :, nx], offset, rtol=1e-6, atol=1e-8)
        for i, direction in enumerate(np.eye(nx)):
            moved = dense.states_and_inputs(dense.solve(direction))[1][0]
            np.testing.assert_allclose(work.policy.gains[first, :, i], moved - offset, rtol=1e-6, atol=1e-7)
    dense = DenseHorizon(work)
    dense.penalize_active(PENALTY)
    dense.regularize(regularization)
    states, inputs = dense.states_and_inputs(dense.solve(np.zeros(nx)))
    step_along(held(work))
    np.testing.assert_allclose(work.trial.states - work.nominal.states, states, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(work.trial.inputs - work.nominal.inputs, inputs, rtol=1e-6, atol=1e-8)
    change = np.abs(work.weights.input * inputs).max()
    assert work.result.change == pytest.approx(change, rel=1e-6)


def test_the_sweep_leaves_the_linearisation_as_it_was(problem: Problem, rng: np.random.Generator) -> None:
    """It borrows the rows' padding for their values."""
    work = random_sweep(problem, rng)
    kept = [array.copy() for array in work.linear]
    for _ in range(2):
        assert swept(problem, work)
        stepped(work)
    for array, before in zip(work.linear, kept, strict=True):
        np.testing.assert_array_equal(array, before)


def test_predicted_decrease_is_that_of_the_dense_program(problem: Problem, rng: np.random.Generator) -> None:
    work = random_sweep(problem, rng, defects=False)
    dense = DenseHorizon(work)
    dense.penalize_active(PENALTY)
    z = dense.solve(np.zeros(problem.nx))
    decrease = -(0.5 * z @ dense.hessian @ z + dense.gradient @ z)
    assert decrease > 0.0
    assert swept(problem, work)
    assert work.result.decrease == pytest.approx(decrease, rel=1e-8)


def test_multipliers_and_activity_follow_from_the_linearised_rows(problem: Problem, rng: np.random.Generator) -> None:
    work = random_sweep(problem, rng)
    dense = DenseHorizon(work)
    dense.penalize_active(PENALTY)
    z = dense.solve(np.zeros(problem.nx))
    rows = dense.rows()
    before = [dense.is_active(name, index) for name, index, *_ in rows]
    assert swept(problem, work)
    flipped = stepped(work)
    now, proposed = [], {name: np.zeros_like(getattr(work.proposal, name)) for name in work.proposal._fields}
    for name, index, slope, value, multiplier in rows:
        force = multiplier + dense.penalty_of(name, index, PENALTY) * (value + slope @ z)
        assert abs(force) > 1e-6
        if len(index) == 2 or name == "end_rows":
            reached = getattr(work.trial, name)[index]
            assert reached == pytest.approx(value + slope @ z, rel=1e-7, abs=1e-8)
        now.append(force > 0.0)
        assert dense.is_active(name, index) == now[-1]
        if force > 0.0:
            proposed[name][index[:2]] += force * (index[2] if len(index) == 3 else 1.0)
    assert flipped == (before != now)
    assert flipped
    for name, expected in proposed.items():
        np.testing.assert_allclose(getattr(work.proposal, name), expected, rtol=1e-6, atol=1e-6, err_msg=name)
    counts = work.active.state_count.copy(), work.active.input_count.copy()
    count_active(work)
    np.testing.assert_array_equal(counts[0], work.active.state_count)
    np.testing.assert_array_equal(counts[1], work.active.input_count)


def test_a_sweep_begins_again_where_the_active_set_flipped_last(problem: Problem, rng: np.random.Generator) -> None:
    work = random_sweep(problem, rng)
    for last in (N - 1, 5, 0, N - 2):
        assert swept(problem, work)
        others = random_horizon(problem, rng, True)
        activate(others, problem, rng)
        for now, new in zip(work.active, others.active, strict=True):
            if len(now) == N:  # node k holds what penalises state k + 1 and input k
                now[: last + 1] = new[: last + 1]
        assert swept(problem, work, last=last)
        part = [np.array(each) for each in (*work.policy, work.result.decrease, work.result.costate)]
        assert swept(problem, work)
        for one, whole in zip(part, (*work.policy, work.result.decrease, work.result.costate), strict=True):
            np.testing.assert_array_equal(one, whole)


def test_a_sweep_that_is_not_convex_is_refused(problem: Problem, rng: np.random.Generator) -> None:
    work = random_sweep(problem, rng)
    for sides in work.active:
        sides[:] = 0
    work.linear.jacobians[:, :, problem.nx + 1 :] *= 0.1
    assert not swept(problem, work, regularization=-1e4)
    assert swept(problem, work)
    work.nominal.states[3, 0] = np.nan
    assert not swept(problem, work)
