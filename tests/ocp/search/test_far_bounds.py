"""Rows and bounds that are never reached change no result, nor the way to it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np
import pytest
from systems import cart_pole

from doorman import ocp

NODES = 50
SLOPES = (-6 + 15 * (np.arange(NODES) + 0.5) / NODES)[:, None]
START = (1.0, 0.0, 0.0)
COST = 5.0822886
"""IPOPT's."""


@cache
def rope(far: bool) -> ocp.Hybrid:
    """A rope of length 4 from height 1 to height 3 hangs lowest; its lowest height is above 0.1."""
    x, u = ca.SX.sym("x", 3), ca.SX.sym("u")  # height, energy so far, length so far; slope
    stretch = ca.sqrt(1 + u**2)
    problem = ocp.SymbolicModel(x, u, ca.vertcat(u, x[0] * stretch, stretch)).problem(
        NODES, 1 / NODES, ocp.QuadraticCost([0] * 3, [0] * 3, [1e-3], [0] * 3, [0.0]),
        bounds=ocp.Bounds(state_lower=[-10.0, -100.0, -100.0]) if far else None,
        constraints=[
            ocp.Constraint("end", x[0], equals=3, at="end"), ocp.Constraint("length", x[2], equals=4, at="end"),
        ],
        costs=[ocp.Cost("energy", x[1], at="end")],
    )  # fmt: skip
    return ocp.Hybrid(problem)


def free() -> ocp.Solution:
    return rope(False).solve(START, SLOPES)


@pytest.mark.slow  # has kernels of its own
@pytest.mark.parametrize("guess", ["slopes", "inputs", "states and inputs", "warm start"])
def test_a_rope_hangs_as_without_its_far_bounds(guess: str) -> None:
    """From the start's guess, and from the solution itself in every way to give it."""
    best = free()
    given = {
        "slopes": {"inputs": SLOPES}, "inputs": {"inputs": best.inputs}, "warm start": {"warm_start": best},
        "states and inputs": {"inputs": best.inputs, "states": best.states},
    }[guess]  # fmt: skip
    for far in (False, True):
        found = rope(far).solve(START, **given)
        assert found.status is ocp.PlanStatus.CONVERGED
        assert found.cost == pytest.approx(COST, rel=1e-7)
        np.testing.assert_allclose(found.states, best.states, atol=2e-3)  # the optimum is flat


@pytest.mark.parametrize("far", [1e3, 1e6])
def test_a_pole_swings_up_as_without_its_far_bounds(far: float) -> None:
    """The cheaper of several minima, from every start."""
    system = cart_pole()
    bounds = replace(system.bounds, state_lower=np.full(4, -far), state_upper=np.full(4, far))
    plain, bounded = ocp.Hybrid(system.problem()), ocp.Hybrid(replace(system, bounds=bounds).problem())
    for start in system.starts(6, seed=21):
        best, found = plain.solve(start), bounded.solve(start)
        assert best.status is found.status is ocp.PlanStatus.CONVERGED
        assert found.cost == pytest.approx(best.cost, rel=1e-6)
