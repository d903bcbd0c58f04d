"""First guesses: rollouts, straight lines, and the previous plan shifted, against numpy."""

from __future__ import annotations

import numpy as np
import pytest
from double_integrator import FAR, STEP, Variant
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from random_horizon import N, cart

from doorman.numba_types.handles import Handle, held
from doorman.ocp.solvers.iterations.guess import (
    aim_straight,
    nearest_shift,
    roll_blindly,
    shift_guess,
    shift_rows,
)
from doorman.ocp.solvers.iterations.nominal import measure
from doorman.ocp.solvers.memory.parts import Multipliers
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.options import SolverOptions

Array = NDArray[np.float64]
SEEDS = st.integers(0, 2**32 - 1)


def interpolated(rows: Array, shift: float) -> Array:
    """Rows `shift` steps later; the last one is held."""
    at = np.arange(len(rows)) + shift
    return np.column_stack([np.interp(at, np.arange(len(rows)), column) for column in rows.T])


@given(SEEDS, st.integers(1, 12), st.floats(0.0, 15.0), st.booleans())
def test_shifted_rows_are_interpolated_and_the_last_one_is_held(seed: int, m: int, shift: float, plain: bool) -> None:
    rows = np.random.default_rng(seed).normal(size=(m, 3))
    expected = interpolated(rows, shift)
    (shift_rows.py_func if plain else shift_rows)(rows, shift)
    np.testing.assert_allclose(rows, expected, atol=1e-12)


@given(SEEDS, st.integers(1, 6), st.booleans())
def test_nearest_point_of_the_polyline(seed: int, limit: int, plain: bool) -> None:
    """No point of a fine sampling of the polyline is nearer than the one found."""
    rng = np.random.default_rng(seed)
    states = np.cumsum(rng.normal(size=(7, 4)), axis=0)
    state = states[0] + rng.normal(size=4)
    weights = rng.uniform(0.0, 5.0, 4)
    shift = (nearest_shift.py_func if plain else nearest_shift)(states, state, weights, limit)
    assert 0.0 <= shift <= limit

    def distance(at: Array | float) -> Array:
        points = np.column_stack([np.interp(np.atleast_1d(at), np.arange(7), column) for column in states.T])
        return (points - state) ** 2 @ weights

    assert distance(shift)[0] <= distance(np.linspace(0.0, limit, 400 * limit + 1)).min() + 1e-12


def test_the_limit_and_the_end_of_the_plan_hold() -> None:
    line = np.arange(5.0)[:, None]
    assert nearest_shift(line, np.array([9.0]), np.ones(1), 2) == 2.0
    assert nearest_shift(line, np.array([9.0]), np.ones(1), 50) == 4.0
    assert nearest_shift(line, np.array([-9.0]), np.ones(1), 2) == 0.0


def random_guess(rng: np.random.Generator) -> Workspace:
    work = Workspace.of(cart())
    for array in (*work.nominal, *work.multipliers):
        array[:] = rng.normal(size=array.shape)
    return work


def at_the_cart() -> Handle:
    return Handle(cart().model)


def shifted_states(work: Workspace, inputs: Array, shift: float) -> Array:
    """States `shift` steps later; behind the plan's end they go on with its last inputs, by the dynamics."""
    states = interpolated(work.nominal.states, shift)
    for k in range(N - int(np.ceil(shift)), N):
        place, speed, boom = states[k]
        acceleration, rate = inputs[k]
        states[k + 1] = [
            place + STEP * (speed + 0.5 * STEP * acceleration),
            speed + STEP * acceleration,
            boom + STEP * rate,
        ]
    return states


def integrated(work: Workspace) -> Array:
    """The last state, the integral of the last input."""
    return work.nominal.states[0, 2] + STEP * np.concatenate([[0.0], np.cumsum(work.nominal.inputs[:, 1])])


@pytest.mark.parametrize("shift", [0.0, 1.0, 1.6])
def test_a_shift_moves_states_inputs_and_multipliers_together(shift: float, rng: np.random.Generator) -> None:
    work = random_guess(rng)
    nominal, multipliers = work.nominal, work.multipliers
    inputs = interpolated(nominal.inputs, shift)
    expected = [shifted_states(work, inputs, shift), inputs]
    moved = {name: interpolated(getattr(multipliers, name), shift) for name in ("input_rows", "inputs")}
    for name in ("rows", "states"):  # those of node N stay there
        rows = getattr(multipliers, name)
        moved[name] = np.vstack([interpolated(rows[:-1], shift), rows[-1:]])
    assert set(moved) == set(Multipliers._fields) - {"end_rows"}
    of_the_end, state = multipliers.end_rows.copy(), rng.normal(size=3)
    shift_guess(at_the_cart(), held(work), state, shift, 2)
    np.testing.assert_array_equal(nominal.states[0], state)
    np.testing.assert_allclose(nominal.states[1:, :2], expected[0][1:, :2], atol=1e-13)
    bounds = cart().bounds
    within = np.clip(expected[1], bounds.input_lower, bounds.input_upper)
    np.testing.assert_allclose(nominal.inputs, within, atol=1e-13)
    np.testing.assert_allclose(nominal.states[:, 2], integrated(work), atol=1e-13)
    for name, rows in moved.items():
        np.testing.assert_allclose(getattr(multipliers, name), rows, atol=1e-13, err_msg=name)
    np.testing.assert_array_equal(multipliers.end_rows, of_the_end)


@pytest.mark.parametrize("shift", [0.0, 1.0, 1.6])
def test_another_first_state_is_met_by_the_last_feedback_within_the_bounds(
    shift: float, rng: np.random.Generator
) -> None:
    """Inputs and states move by the policy and the dynamics of the nodes that the plan is shifted to."""
    problem = cart()
    work = random_guess(rng)
    work.policy.gains[:] = 0.1 * rng.normal(size=work.policy.gains.shape)
    work.linear.jacobians[:] = 0.5 * rng.normal(size=work.linear.jacobians.shape)
    on_its_way = interpolated(work.nominal.states, shift)[0]
    inputs = interpolated(work.nominal.inputs, shift)
    plain = [shifted_states(work, inputs, shift), inputs]
    state = on_its_way + 0.1 * rng.normal(size=3)
    change, expected = state - on_its_way, [plain[0].copy(), plain[1].copy()]
    for k in range(N):
        node = min(k + round(shift), N - 1)
        wanted = plain[1][k] + work.policy.gains[node, :, :3] @ change
        expected[1][k] = np.clip(wanted, problem.bounds.input_lower, problem.bounds.input_upper)
        jacobian = work.linear.jacobians[node]
        change = jacobian[:, :3] @ change + jacobian[:, 4:6] @ (expected[1][k] - plain[1][k])
        expected[0][k + 1] += change
    shift_guess(at_the_cart(), held(work), state, shift, 2)
    np.testing.assert_array_equal(work.nominal.states[0], state)
    np.testing.assert_allclose(work.nominal.inputs, expected[1], atol=1e-12)
    np.testing.assert_allclose(work.nominal.states[1:, :2], expected[0][1:, :2], atol=1e-12)
    np.testing.assert_allclose(work.nominal.states[:, 2], integrated(work), atol=1e-13)


def test_a_blind_rollout_obeys_the_dynamics_whatever_it_violates(rng: np.random.Generator) -> None:
    variant = Variant(wall=0.0, bend=0.8, horizon=N)
    work = random_guess(rng)
    roll_blindly(Handle(variant.model()), held(work), 0)
    assert variant.defect(work.nominal.states, work.nominal.inputs) <= 1e-13


def test_a_straight_line_leads_to_the_goal_within_the_rates(rng: np.random.Generator) -> None:
    for rate, reaches in ((FAR, True), (0.1, False)):
        problem = Variant(rate=(-rate, rate), horizon=N).problem()
        work = Workspace.of(problem)
        work.nominal.states[0] = rng.normal(size=3)
        aim_straight(held(work))
        states, goal = work.nominal.states, problem.cost.state_goal
        np.testing.assert_allclose(states[:, :2], np.linspace(states[0, :2], goal[:2], N + 1), atol=1e-13)
        assert (states[-1, 2] == pytest.approx(goal[2])) == reaches
        assert np.abs(np.diff(states[:, 2])).max() <= STEP * rate + 1e-12


@pytest.mark.parametrize(
    ("field", "index", "node"),
    [
        (None, None, -1), ("rows", (2, 1), 3), ("input_rows", (4, 0), 4), ("end_rows", (0,), N), ("states", (5, 0), 5),
        ("inputs", (3, 1), 3),
    ],
)  # fmt: skip
def test_the_last_violated_node(field: str | None, index: tuple[int, ...], node: int) -> None:
    work = Workspace.of(cart(), SolverOptions(feasibility=0.5))
    for values in (work.nominal.rows, work.nominal.input_rows, work.nominal.end_rows):
        values[:] = -1.0
    work.nominal.states[0] = 9.0  # the start itself is not constrained

    def last() -> float:
        measure(held(work), work.nominal)
        return float(work.result.last_violated)

    assert last() == -1
    if field is not None:
        array, inside = getattr(work.nominal, field), getattr(work.nominal, field)[index]
        for value, expected in ((9.0, node), (inside, -1), (np.nan, node)):
            array[index] = value
            assert last() == expected
