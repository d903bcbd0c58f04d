"""Problems from expressions: IPOPT's optimum, parameters that compile nothing, copies, and errors that name what is wrong."""

from __future__ import annotations

import subprocess
import sys

import casadi as ca
import numpy as np
import pytest
import unicycle

from doorman import ocp
from doorman.compilation import kernel_counts
from doorman.exceptions import DimensionError, DoormanError, SolverError
from doorman.ocp.kernels import functions

QUADRATIC = ocp.QuadraticCost([1.0, 1.0], [1.0, 1.0], [1.0], [0.0, 0.0], [0.0])


@pytest.fixture(scope="module")
def solver() -> ocp.Hybrid:
    return ocp.Hybrid(unicycle.problem())


@pytest.mark.slow
def test_every_kind_of_term_together_has_the_optimum_of_ipopt(solver: ocp.Hybrid) -> None:
    solution = solver.solve(unicycle.START)
    cost, states = unicycle.ipopt((solution.states, solution.inputs))
    assert solution.status is ocp.PlanStatus.CONVERGED
    assert solution.cost == pytest.approx(cost, rel=1e-6)
    assert np.abs(solution.states - states).max() < 1e-3
    assert solution.kkt_residual < 1e-3
    distances = np.hypot(*(solution.states[1:, :2] - unicycle.nodes()[1:, :2]).T)
    assert distances.min() == pytest.approx(0.5, abs=1e-5)  # the obstacle binds, so that this shows something


@pytest.mark.slow
def test_new_parameters_compile_nothing_and_change_the_optimum(solver: ocp.Hybrid) -> None:
    before, counts = solver.solve(unicycle.START), kernel_counts()
    parameters, at = np.array([0.3, 5.0]), unicycle.nodes(speed=0.1)
    solver.update_parameters(parameters, at)
    solution = solver.solve(unicycle.START)
    cost, _ = unicycle.ipopt((solution.states, solution.inputs), parameters, at)
    assert solution.cost == pytest.approx(cost, rel=1e-6) and abs(solution.cost - before.cost) > 1e-3
    assert solution.problem.model.parameters.tolist() == parameters.tolist()
    assert before.problem.model.parameters.tolist() == unicycle.PARAMETERS.tolist()
    solver.update_parameters(unicycle.PARAMETERS, unicycle.nodes())
    again = solver.solve(unicycle.START)
    assert np.array_equal(again.states, before.states)
    assert kernel_counts() == counts


@pytest.mark.slow
def test_another_process_compiles_nothing(solver: ocp.Hybrid) -> None:
    program = (
        "import unicycle; from doorman import ocp; from doorman.compilation import kernel_counts\n"
        "print(ocp.Hybrid(unicycle.problem()).solve(unicycle.START).cost.hex(), kernel_counts().compiled)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=unicycle.__file__.rpartition("/")[0], capture_output=True, text=True
    )
    assert done.stdout.split() == [solver.solve(unicycle.START).cost.hex(), "0"], done.stderr


def test_derivatives_are_those_of_casadi() -> None:
    problem, random = unicycle.problem(), np.random.default_rng(3)
    symbols = [unicycle.x, unicycle.u, unicycle.p, unicycle.q]
    ahead = unicycle.step(unicycle.x, unicycle.u)
    terms = unicycle.TIME_STEP * (unicycle.LANE + unicycle.HASTE)
    both = ca.vertcat(unicycle.x, unicycle.u)
    truth = ca.Function("truth", symbols, [
        ca.jacobian(ahead, both), unicycle.OBSTACLE / 2.0, ca.jacobian(unicycle.OBSTACLE / 2.0, unicycle.x),
        ca.gradient(terms, both), terms,
    ])  # fmt: skip
    for k in random.integers(0, unicycle.HORIZON, 20):
        x, u = random.uniform(-1.0, 1.0, 3), random.uniform(-1.0, 1.0, 2)
        slopes, row, row_slope, gradient, value = (
            np.array(each) for each in truth(x, u, unicycle.PARAMETERS, unicycle.nodes()[k])
        )
        node = functions.at_node(problem.model, int(k))
        jacobian, h, h_x = np.full((3, 5), np.nan), np.zeros(1), np.full((1, 3), np.nan)
        g, hessian = np.zeros(5), np.zeros((5, 5))
        functions.linearize_step(node, x, u, jacobian)
        functions.linearize_constraints(node, x, h, h_x)
        functions.expand_stage_cost(node, x, u, g, hessian)
        for found, expected in ((jacobian, slopes), (h, row.ravel()), (h_x, row_slope), (g, gradient.ravel())):
            assert np.allclose(found, expected, rtol=1e-12, atol=1e-13)
        assert functions.stage_cost(node, x, u) == pytest.approx(float(value.item()), rel=1e-13)
        assert np.linalg.eigvalsh(hessian).min() > -1e-12


def test_integrators_are_found() -> None:
    x, u = ca.SX.sym("x", 3), ca.SX.sym("u", 2)
    cost = ocp.QuadraticCost(*[[1.0] * 3] * 2, [1.0] * 2, [0.0] * 3, [0.0] * 2)
    counts = {
        "one": ca.vertcat(x[1], u[0], u[1]),
        "two": ca.vertcat(-x[0], u[0], u[1]),
        "none: another state depends on it": ca.vertcat(x[2], u[0], u[1]),
        "none: not the last": ca.vertcat(u[0], u[1], x[0]),
    }
    for what, rate in counts.items():
        found = ocp.SymbolicModel(x, u, rate).problem(horizon=5, time_step=0.1, cost=cost).integrators
        assert found == {"one": 1, "two": 2}.get(what, 0), what


def _problem(**changed):
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    model = {"dynamics": ca.vertcat(x[1], u), "integrator": "rk4", "steps": 1, "parameters": None}
    model |= {key: value(x, u) for key, value in changed.items() if key in model}
    rest = {"horizon": 5, "time_step": 0.1, "cost": QUADRATIC}
    rest |= {key: value(x, u) for key, value in changed.items() if key not in model or key == "values"}
    return ocp.SymbolicModel(x, u, **model).problem(**rest)


BAD = [
    ({"dynamics": lambda x, u: ca.vertcat(x[1], u, u)}, DimensionError, "dynamics"),
    ({"dynamics": lambda x, u: ca.vertcat(x[1], ca.SX.sym("wind"))}, SolverError, "wind"),
    ({"dynamics": lambda x, u: ca.vertcat(x[1], ca.erfinv(x[0]))}, SolverError, "ERFINV"),
    ({"dynamics": lambda x, u: ca.MX.sym("m", 2)}, SolverError, "dynamics"),
    ({"dynamics": lambda x, u: "x[1]"}, SolverError, "dynamics"),
    ({"integrator": lambda x, u: "rk5"}, SolverError, "rk5"),
    ({"steps": lambda x, u: 0}, DimensionError, "steps"),
    ({"parameters": lambda x, u: 2.0 * x}, SolverError, "parameters"),
    ({"constraints": lambda x, u: [ocp.Constraint("a", x[0]), ocp.Constraint("a", x[1])]}, SolverError, "a"),
    ({"constraints": lambda x, u: [ocp.Constraint("end", u, at="end")]}, SolverError, "end"),
    ({"constraints": lambda x, u: [ocp.Constraint("a", x[0], at="start")]}, SolverError, "a.at"),
    ({"constraints": lambda x, u: [ocp.Constraint("a", x[0], scale=0.0)]}, SolverError, "a.scale"),
    ({"constraints": lambda x, u: [x[0]]}, SolverError, "constraints[0]"),
    ({"constraints": lambda x, u: ocp.Constraint("a", x[0])}, SolverError, "constraints"),
    ({"costs": lambda x, u: [ocp.Constraint("a", x[0])]}, SolverError, "costs[0]"),
    ({"horizon": lambda x, u: 5.5}, DimensionError, "horizon"),
    ({"costs": lambda x, u: [ocp.Cost("twice", x)]}, DimensionError, "twice"),
    ({"costs": lambda x, u: [ocp.Residual("r", x, weights=[1.0, 2.0, 3.0])]}, DimensionError, "r.weights"),
    ({"cost": lambda x, u: ocp.QuadraticCost([1.0], [1.0], [1.0], [0.0], [0.0])}, DimensionError, "state_goal"),
    ({"node_parameters": lambda x, u: [1.0]}, DimensionError, "node_parameters"),
]  # fmt: skip


@pytest.mark.parametrize(("changed", "kind", "named"), BAD, ids=range(len(BAD)))
def test_what_cannot_be_is_refused_by_name(changed, kind, named) -> None:
    with pytest.raises(kind) as caught:
        _problem(**changed)
    assert named in str(caught.value) and isinstance(caught.value, DoormanError)


@pytest.mark.slow
def test_wrong_parameters_are_refused(solver: ocp.Hybrid) -> None:
    for given in (([1.0],), ([1.0, np.nan],), (None, np.zeros((3, 3)))):
        with pytest.raises(DimensionError):
            solver.update_parameters(*given)
