"""Equalities, rows with two ends, and full weights, by all solvers that take them; multipliers beside IPOPT's."""

from __future__ import annotations

import numpy as np
import pytest
from system import System
from systems import parking

from doorman import ocp
from doorman.exceptions import DimensionError, SolverError


@pytest.fixture(scope="module")
def system() -> System:
    return parking()


@pytest.fixture(scope="module")
def solvers(system: System) -> dict[str, ocp.Solver]:
    fast = ocp.SolverOptions(hessian="gauss-newton")
    return {
        "both": ocp.Hybrid(system.problem()),
        "fast": ocp.Hybrid(system.problem(), fast),
    }


@pytest.mark.slow
@pytest.mark.parametrize("name", ["both", "fast"])
def test_the_optimum_is_ipopts(system: System, solvers: dict[str, ocp.Solver], name: str) -> None:
    for start in system.starts(4, seed=1):
        solution = solvers[name].solve(start)
        reference = system.ipopt(start, solution.states, solution.inputs)
        assert reference.success and solution.status is ocp.PlanStatus.CONVERGED, solution.message()
        assert solution.cost == pytest.approx(reference.cost, rel=1e-6)
        assert np.abs(solution.states - reference.states).max() < 1e-3
        assert np.abs(solution.states[-1] - [2.0, 1.0, 0.0, 0.0]).max() < 2e-6
        assert solution.kkt_residual < 1e-3


@pytest.mark.slow
def test_multipliers_are_ipopts(system: System, solvers: dict[str, ocp.Solver]) -> None:
    """Signs, scales and Δt: of both ends of a row, equalities, bounds and dynamics."""
    start = np.asarray(system.start)
    solution = solvers["both"].solve(start)
    reference = system.ipopt(start, solution.states, solution.inputs)
    mine = np.concatenate([*_by_term(system, solution), solution.multipliers.inputs.ravel()])
    theirs = np.concatenate([reference.prices.ravel(), reference.bound_prices.ravel()])
    assert mine.shape == theirs.shape and np.abs(theirs).max() > 0.1
    assert np.abs(mine - theirs).max() < 1e-3 * np.abs(theirs).max()
    assert np.abs(solution.costates - reference.costates).max() < 1e-3 * np.abs(reference.costates).max()


def _by_term(system: System, solution: ocp.Solution) -> list[np.ndarray]:
    """Prices of rows in the order of the terms, of two-sided ones the upper end's less the lower end's."""
    given, names = solution.multipliers, solution.problem.constraint_names
    nh, ng = solution.problem.n_constraints, solution.problem.n_input_constraints
    kinds = [given.rows, given.input_rows, given.end_rows[None]]
    columns = [kind[:, i] for kind in kinds for i in range(kind.shape[1])]
    assert len(columns) == len(names) and nh == 2 and ng == 3
    found = []
    for term in system.constraints:
        own = {name: column for name, column in zip(names, columns, strict=True) if name.startswith(term.name)}
        signs = {name: -1.0 if " lower" in name else 1.0 for name in own}
        if any("lower" in name for name in own):
            found.append(sum(signs[name] * column for name, column in own.items()))
        else:
            found += [np.concatenate(list(own.values()))]
    return found


def test_a_constraint_has_ends_that_make_sense() -> None:
    model = parking()
    for ends in ({"lower": 1.0, "upper": 0.0}, {"equals": 0.0, "upper": 1.0}, {"upper": np.inf}, {"upper": [0.0, 1.0]}):
        with pytest.raises(SolverError, match="speed"):
            ocp.SymbolicModel(model.x, model.u, model.rate).problem(
                5, 0.1, model.cost, constraints=[ocp.Constraint("speed", model.x[3], **ends)]
            )
    problem = ocp.SymbolicModel(model.x, model.u, model.rate).problem(
        5, 0.1, model.cost,
        constraints=[
            ocp.Constraint("a", model.x[:2], lower=[-np.inf, 1.0], upper=[2.0, 1.0], unit="m"),
            ocp.Constraint("b", model.x[2], lower=-1.0),
            ocp.Constraint("c", model.x[2], lower=-1.0, upper=1.0),
        ],
    )  # fmt: skip
    assert problem.constraint_names == ("a 0 [m]", "a 1 [m]", "b", "c upper", "c lower")
    assert problem.equalities == (False, True, False, False, False)


def test_cddp_takes_no_equalities(system: System) -> None:
    with pytest.raises(SolverError, match="equalities"):
        ocp.Cddp(system.problem())


@pytest.mark.parametrize(
    "change",
    [
        {"state_weights": np.diag([1.0, -1.0])},
        {"state_weights": [[1.0, 0.5], [0.4, 1.0]]},
        {"input_weights": [[-1.0]]},
        {"terminal_weights": np.eye(3)},
        {"cross_weights": [[2.0, 0.0]]},
        {"cross_weights": [[0.1]]},
    ],
)
def test_weights_that_are_none_are_refused(change: dict[str, object]) -> None:
    weights = {"state_weights": np.eye(2), "terminal_weights": [1.0, 1.0], "input_weights": [1.0]}
    goals = {"state_goal": [0.0, 0.0], "input_goal": [0.0]}
    ocp.QuadraticCost(**weights, **goals)  # type: ignore[arg-type]
    with pytest.raises(DimensionError, match=next(iter(change))):
        ocp.QuadraticCost(**{**weights, **goals, **change})  # type: ignore[arg-type]


def test_full_weights_cost_what_their_equation_says(system: System) -> None:
    cost, random = system.cost, np.random.default_rng(0)
    states, inputs = random.normal(size=(6, 4)), random.normal(size=(5, 3))
    expected = 0.5 * (states[5] - cost.state_goal) @ cost.terminal_weights @ (states[5] - cost.state_goal)
    for x, u in zip(states[:5] - cost.state_goal, inputs - cost.input_goal, strict=True):
        expected += 0.1 * (
            0.5 * x @ cost.state_weights @ x + 0.5 * u @ cost.input_weights @ u + u @ cost.cross_weights @ x
        )
    assert cost.total(states, inputs, 0.1) == pytest.approx(expected, rel=1e-12)
