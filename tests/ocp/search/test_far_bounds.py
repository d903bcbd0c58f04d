"""Rows and bounds that are never reached change no result, nor the way to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from systems import cart_pole

from doorman import ocp


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
