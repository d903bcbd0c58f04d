"""Rollouts of a policy: exact dynamics, bounds and rows; corrections against ProxQP in plain numpy."""

from __future__ import annotations

import numpy as np
import pytest
from double_integrator import COST, STEP, Variant
from numpy.typing import NDArray
from proxsuite import proxqp

from doorman.numba_types.handles import Handle, held
from doorman.ocp.solvers.iterations.correction import FEASIBILITY
from doorman.ocp.solvers.iterations.rollout import DONE, NOT_FINITE, roll_out
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.options import SolverOptions
from doorman.ocp.solvers.sweeps.stage_qp import StageQpSolver

Array = NDArray[np.float64]

N = 12
FREE = Variant(horizon=N)
BOUND = Variant(
    start=(0.1, 0.4, 0.0), wall=0.9, reach=0.4, speed=0.8, power=0.9, force=(-20.0, 0.7), rate=(-0.3, 0.3),
    boom=(-0.05, 0.1), horizon=N,
)  # fmt: skip
"""Every row of it can be kept from node to node: the brakes are strong."""


def policy_of(variant: Variant, rng: np.random.Generator, guess: bool = True) -> Workspace:
    """A nominal trajectory that obeys the dynamics, and a random policy around it."""
    work = Workspace.of(variant.problem(), SolverOptions(guess_active_sets=guess))
    work.nominal.inputs[:] = rng.normal(size=(N, 2)) * [1.0, 0.3]
    work.nominal.states[0] = variant.start
    for k in range(N):
        work.nominal.states[k + 1] = following(variant, work.nominal.states[k], work.nominal.inputs[k])
    work.policy.gains[:, :, :4] = 0.4 * rng.normal(size=(N, 2, 4))
    work.policy.factors[:, 0, :2] = np.column_stack([rng.uniform(0.1, 1.0, N), 0.3 * rng.normal(size=N)])
    work.policy.factors[:, 1, 1] = rng.uniform(0.1, 1.0, N)
    for array in work.trial:
        array[:] = np.nan
    work.trial.states[0] = np.array(variant.start) + [0.01, -0.02, 0.03]
    return work


def following(variant: Variant, x: Array, u: Array) -> Array:
    pushed = u[0] + variant.bend * np.sin(x[0])
    return np.array([x[0] + STEP * x[1] + 0.5 * STEP**2 * pushed, x[1] + STEP * pushed, x[2] + STEP * u[1]])


def roll(variant: Variant, work: Workspace, scale: float) -> tuple[int, int]:
    """A whole rollout: its code, and the number of corrections that were left to ProxQP."""
    model, memory, qp, asked = Handle(variant.model()), held(work), StageQpSolver(2, len(work.program.constraints)), 0
    code = roll_out(model, memory, -1, scale, 0)
    while code >= 0:
        asked += 1
        corrections = int(work.result.corrections) + 1 if qp.solve(work.program) else -1
        code = roll_out(model, memory, code, scale, corrections)
    return int(code), asked


def rows_at(variant: Variant, k: int, x: Array, u: Array) -> tuple[Array, Array]:
    """D and c of everything that input k is responsible for; linear in the input where the cart does not bend."""
    p, v, q = following(variant, x, u)
    by_p, by_v, by_q = np.array([0.5 * STEP**2, 0.0]), np.array([STEP, 0.0]), np.array([0.0, STEP])
    a, r = np.eye(2)
    rows = [(by_p + variant.reach * by_q, p + variant.reach * q - variant.wall), (by_v, v - variant.speed)]
    if k == N - 1:
        rows.append((-by_p, variant.dock - p))
    rows.append((a, u[0] + x[1] - variant.power))
    for slope, number, (low, high) in (
        (by_p, p, variant.room), (by_q, q, variant.boom), (a, u[0], variant.force), (r, u[1], variant.rate)
    ):  # fmt: skip
        rows += [(slope, number - high), (-slope, low - number)]
    return np.array([row for row, _ in rows]), np.array([value for _, value in rows])


def plain_rollout(variant: Variant, work: Workspace, scale: float) -> tuple[Array, Array, int]:
    """States, inputs, and how many inputs had to be corrected."""
    states, inputs, corrected = [work.trial.states[0].copy()], [], 0
    for k in range(N):
        x, gains = states[-1], work.policy.gains[k]
        u = work.nominal.inputs[k] + scale * gains[:, 3] + gains[:, :3] @ (x - work.nominal.states[k])
        u = np.clip(u, *np.array([variant.force, variant.rate]).T)
        rows, values = rows_at(variant, k, x, u)
        if values.max() > FEASIBILITY:
            corrected += 1
            factors = work.policy.factors[k, :, :2]
            upper = np.triu(factors, 1) + np.eye(2)
            qp = proxqp.dense.QP(2, 0, len(values))
            qp.settings.eps_abs, qp.settings.eps_rel = 1e-12, 0.0
            hessian = upper.T @ np.diag(np.diag(factors)) @ upper
            qp.init(hessian, np.zeros(2), None, None, rows, np.full(len(values), -1e20), -values)
            qp.solve()
            assert qp.results.info.status == proxqp.QPSolverOutput.PROXQP_SOLVED
            u = u + qp.results.x
        inputs.append(u)
        states.append(following(variant, x, u))
    return np.array(states), np.array(inputs), corrected


@pytest.mark.parametrize("guess", [True, False])
@pytest.mark.parametrize("scale", [0.0, 0.5, 1.0])
def test_inputs_are_the_policys_or_their_nearest_that_keep_the_rows(
    scale: float, guess: bool, rng: np.random.Generator
) -> None:
    corrected = 0
    for variant in (FREE, BOUND, BOUND):
        work = policy_of(variant, rng, guess)
        states, inputs, changed = plain_rollout(variant, work, scale)
        code, asked = roll(variant, work, scale)
        assert code == DONE
        assert guess or asked >= changed
        np.testing.assert_allclose(work.trial.inputs, inputs, atol=1e-6)
        np.testing.assert_allclose(work.trial.states, states, atol=1e-7)
        assert variant.defect(work.trial.states, work.trial.inputs) <= 1e-14
        assert variant.violation(work.trial.states, work.trial.inputs) <= FEASIBILITY
        assert work.result.relaxed == 0
        cost = COST.total(work.trial.states, work.trial.inputs, STEP)
        assert work.result.cost == pytest.approx(cost, rel=1e-13)
        assert work.result.violation <= FEASIBILITY
        corrected += changed
        if variant is FREE:
            assert changed == asked == 0
    assert corrected >= 4


def test_nonlinear_rows_take_more_than_one_correction_and_hold(rng: np.random.Generator) -> None:
    """Twelve radians of bend: the next place is no linear function of the place, but of the input it is."""
    variant = Variant(start=(0.2, 0.3, 0.0), wall=0.6, reach=0.4, bend=3.0, horizon=N)
    work = policy_of(variant, rng)
    assert roll(variant, work, 1.0)[0] == DONE
    assert variant.violation(work.trial.states, work.trial.inputs) <= FEASIBILITY
    assert variant.defect(work.trial.states, work.trial.inputs) <= 1e-14


def test_rows_that_cannot_be_kept_are_passed_with_the_policys_input(rng: np.random.Generator) -> None:
    """The brakes are weak and the wall is near; bounds of inputs hold, and the worst row is named."""
    variant = Variant(start=(0.5, 0.9, 0.0), wall=0.6, force=(-0.3, 0.3), rate=(-0.1, 0.1), horizon=N)
    for guess in (True, False):
        work = policy_of(variant, np.random.default_rng(4), guess)
        work.policy.gains[:, :, :3] = 0.0
        assert roll(variant, work, 1.0)[0] == DONE
        states, inputs = work.trial.states, work.trial.inputs
        assert variant.defect(states, inputs) <= 1e-14
        assert np.abs(inputs[:, 0]).max() <= 0.3 and np.abs(inputs[:, 1]).max() <= 0.1
        beyond = states[1:, 0] - 0.6
        assert work.result.relaxed >= (beyond > 1e-6).sum() > 5
        policy = np.clip(work.nominal.inputs + work.policy.gains[:, :, 3], [-0.3, -0.1], [0.3, 0.1])
        np.testing.assert_allclose(inputs, policy, atol=1e-12)
        assert work.result.violation == pytest.approx(beyond.max(), abs=1e-12)
        assert work.result.node == 1 + beyond.argmax()
        assert work.result.row == 0


def test_numbers_out_of_hand_end_a_rollout(rng: np.random.Generator) -> None:
    variant = Variant(start=(1.0, 0.0, 0.0), bend=1e9, horizon=N)
    work = policy_of(FREE, rng)
    assert roll(variant, work, 1.0)[0] == NOT_FINITE
