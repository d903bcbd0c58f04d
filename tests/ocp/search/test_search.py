"""The search for a good minimum: as good as IPOPT's from the same guess, and honest where there is none."""

from __future__ import annotations

import numpy as np
import pytest
from system import System
from systems import cart_pole

from doorman import ocp


@pytest.fixture(scope="module")
def cart() -> tuple[System, ocp.Hybrid]:
    system = cart_pole()
    return system, ocp.Hybrid(system.problem())


@pytest.mark.slow
@pytest.mark.parametrize("guess", [None, "held"])
def test_a_pole_swings_up_as_cheaply_as_ipopt_has_it(cart: tuple[System, ocp.Hybrid], guess: str | None) -> None:
    """Gauss and Newton's Hessian alone ends at more than twice the cost from half of these starts."""
    system, solver = cart
    for start in system.starts(8, seed=3):
        solution = solver.solve(start, states=guess)
        reference = system.ipopt(start, system.held(start), np.zeros((system.horizon, 1)))
        assert solution.status is ocp.PlanStatus.CONVERGED and solution.defect < 1e-9
        assert solution.cost <= reference.cost * (1.0 + 1e-6)
        assert solution.kkt_residual < 1e-2  # the cost is in the thousands


@pytest.mark.slow
def test_a_guess_in_a_word_is_the_array_that_it_names(cart: tuple[System, ocp.Hybrid]) -> None:
    system, solver = cart
    start = next(system.starts(1))
    part = np.linspace(0.0, 1.0, system.horizon + 1)[:, None]
    for word, states in (("held", system.held(start)), ("straight", (1.0 - part) * start)):
        named, given = solver.solve(start, states=word), solver.solve(start, np.zeros((50, 1)), states=states)
        assert named.cost == pytest.approx(given.cost, rel=1e-9) and named.iterations == given.iterations
