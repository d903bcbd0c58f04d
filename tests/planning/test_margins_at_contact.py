"""Margins of the loop that plans close at the contact, linearised there: gain, dead time and lag may be off."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from doorman import Planner, Scenario

LAG, DEAD, H = 0.16, 3, 0.02
"""Believed lag [s], dead time in steps of the plan, and that step [s]."""


def slopes(of, at: np.ndarray, size: float) -> np.ndarray:
    columns = [(of(at + size * one) - of(at - size * one)) / (2.0 * size) for one in np.eye(len(at))]
    return np.array(columns).T


@cache
def feedback() -> tuple[np.ndarray, np.ndarray, np.ndarray, Planner]:
    """What a plan answers to its state, [u by x], at the tip resting on the leaf, with that state and input."""
    planner = Planner(Scenario.load("push", {"vehicle.attitude_lag": LAG}))
    x = planner.planning.start_state
    first = planner.plan(x).inputs[0].copy()
    return slopes(lambda state: planner.plan(state).inputs[0].copy(), x, 2e-5), x, first, planner


def motion(lag: float) -> tuple[np.ndarray, np.ndarray]:
    """Step of the linearised contact behind a loop of this lag, [by x] and [by u]."""
    _, x, u, _ = feedback()
    planner = Planner(Scenario.load("push", {"vehicle.attitude_lag": lag}))
    by_state = slopes(lambda state: planner.carried(state, [u]), x, 1e-6)
    return by_state, slopes(lambda inputs: planner.carried(x, [inputs]), u, 1e-6)


def growth(lag: float, dead: int, gain: float) -> float:
    """Largest factor per step of the closed loop, whose plans begin where the commands under way lead by what is believed."""
    k, x, u, _ = feedback()
    a, b = motion(LAG)
    true_a, true_b = motion(lag)
    n, m, kept = len(x), len(u), max(dead, DEAD)
    ahead = np.linalg.matrix_power(a, DEAD)
    # state: x, then the inputs sent 1, 2, … kept steps ago
    size = n + kept * m
    plan = np.zeros((m, size))
    plan[:, :n] = k @ ahead
    for ago in range(1, DEAD + 1):
        plan[:, n + (ago - 1) * m : n + ago * m] = k @ np.linalg.matrix_power(a, ago - 1) @ b
    plan[1:3] *= gain
    loop = np.zeros((size, size))
    loop[:n, :n] = true_a
    if dead:
        loop[:n, n + (dead - 1) * m : n + dead * m] = true_b
    else:
        loop[:n] += true_b @ plan
    loop[n : n + m] = plan
    loop[n + m :, n:-m] = np.eye((kept - 1) * m)
    return float(np.abs(np.linalg.eigvals(loop)).max())


@pytest.mark.slow
@pytest.mark.parametrize("lag", [0.6, 1.0, 1.4])
@pytest.mark.parametrize("dead", [-2, 0, 2])
def test_a_loop_off_by_40_percent_and_40_ms_is_stable(lag: float, dead: int) -> None:
    assert growth(lag * LAG, DEAD + dead, 1.0) < 1.001


@pytest.mark.parametrize("gain", [0.5, 2.0])
def test_gain_margin_of_6_db_and_phase_margin(gain: float) -> None:
    """Half and twice the tilt that plans ask for; and one step more of dead time, 30° at 4 Hz."""
    assert growth(LAG, DEAD, gain) < 1.001
    assert growth(LAG, DEAD + 1, 1.0) < 1.001
