"""A node's quadratic program by its dual, against ProxQP; and when it has to be left to ProxQP."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from random_horizon import cart, door

from doorman.numba_types.handles import held
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.stage_program import (
    ROW_TOLERANCE,
    export_program,
    project_row,
    solve_dual,
    substitute_step,
)
from doorman.ocp.solvers.sweeps.stage_qp import StageQpSolver

Array = NDArray[np.float64]

K = 2
"""Node whose factors the programs take."""


@pytest.fixture(params=[cart, door])
def problem(request: pytest.FixtureRequest) -> Problem:
    return request.param()


def random_program(problem: Problem, rng: np.random.Generator) -> Workspace:
    """Min ½ vᵀQ_uu v subject to c + D v ≤ 0 with a strictly feasible point, as `rollout` sets it up."""
    work, nu = Workspace.of(problem), problem.nu
    program, factors = work.program, work.policy.factors[K]
    factors[:] = np.nan
    factors[:, :nu] = np.triu(0.5 * rng.normal(size=(nu, nu)), 1) + np.diag(rng.uniform(0.1, 3.0, nu))
    jacobian = rng.normal(size=program.jacobian.shape)
    set_rows(work, jacobian, -jacobian @ rng.normal(size=nu) - rng.uniform(0.01, 2.0, len(jacobian)))
    guess = rng.integers(3)  # the violated rows as in a rollout, none, or two as from an earlier pass
    program.proposal[:] = program.constraints > 0.0 if guess == 0 else False
    if guess == 2:
        program.proposal[rng.choice(len(jacobian), 2, replace=False)] = True
    program.multipliers[:] = np.nan
    return work


def set_rows(work: Workspace, jacobian: Array, constraints: Array) -> None:
    program = work.program
    program.jacobian[:], program.constraints[:], program.residuals[:] = jacobian, constraints, constraints
    for row, projected in zip(jacobian, program.projected, strict=True):
        project_row(work.policy.factors[K], row, projected)


def hessian_of(work: Workspace) -> Array:
    nu = work.policy.factors.shape[1]
    factors = work.policy.factors[K, :, :nu]
    upper = np.triu(factors, 1) + np.eye(nu)
    return upper.T @ np.diag(np.diag(factors)) @ upper


def solved(work: Workspace) -> bool:
    memory = held(work)
    if not solve_dual(memory, K):
        return False
    substitute_step(memory, K)
    return True


def test_a_guess_that_settles_is_the_solution(problem: Problem, rng: np.random.Generator) -> None:
    """Compared with ProxQP, which also gets the program through `export_program`; most guesses settle."""
    qp, settled, active = StageQpSolver(problem.nu, len(Workspace.of(problem).program.constraints)), 0, 0
    for _ in range(200):
        work = random_program(problem, rng)
        export_program(held(work), K, False)
        np.testing.assert_allclose(work.program.hessian, hessian_of(work), rtol=1e-12, atol=1e-12)
        np.testing.assert_array_equal(work.program.gradient, 0.0)
        if not solved(work):
            continue
        settled += 1
        step, multipliers = work.program.step.copy(), work.program.multipliers.copy()
        assert qp.solve(work.program)
        np.testing.assert_allclose(step, work.program.step, atol=1e-3)
        scale = 1.0 + np.abs(multipliers).max()
        np.testing.assert_allclose(multipliers, work.program.multipliers, atol=1e-3 * scale)
        residuals = work.program.constraints + work.program.jacobian @ step
        assert residuals.max() <= ROW_TOLERANCE + 1e-9
        assert (multipliers >= 0.0).all()
        assert not multipliers[~work.program.proposal].any()
        np.testing.assert_allclose(hessian_of(work) @ step, -work.program.jacobian.T @ multipliers, atol=1e-8 * scale)
        active += int((multipliers > 1e-6).sum())
    assert settled >= (180 if problem.nu == 8 else 60)
    assert active > 60


def test_rows_that_contradict_each_other_do_not_settle(problem: Problem, rng: np.random.Generator) -> None:
    for amount in (1.0, 1e-6):
        work = random_program(problem, rng)
        jacobian, constraints = work.program.jacobian.copy(), -np.ones(len(work.program.constraints))
        jacobian[1], constraints[:2] = -jacobian[0], amount
        set_rows(work, jacobian, constraints)
        work.program.proposal[:] = False
        assert not solved(work)


def test_a_row_that_no_input_moves_does_not_settle_unless_it_holds(problem: Problem, rng: np.random.Generator) -> None:
    work = random_program(problem, rng)
    jacobian, constraints = work.program.jacobian.copy(), -np.ones(len(work.program.constraints))
    jacobian[0], constraints[1] = 0.0, 0.5
    for value, settles in ((0.5, False), (-0.5, True)):
        constraints[0] = value
        set_rows(work, jacobian, constraints)
        work.program.proposal[:] = False
        assert solved(work) == settles
