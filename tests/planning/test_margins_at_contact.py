"""Margins of the loop that plans close at the contact, linearised there: gain, dead time and lag may be off."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from doorman import Planner, Scenario

LAG, DEAD, H = 0.16, 3, 0.02
"""Believed lag [s], dead time in steps of the plan, and that step [s]."""
SLOW = 0.1
"""Turn of a mode in a step below which it does not count as swinging, 0.8 Hz [rad]."""


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


def growth(lag: float, dead: int, gain: float, believed: int = DEAD) -> float:
    """Largest factor per step of what oscillates in the closed loop, whose plans begin where the commands under way lead.

    What does not oscillate is what the plan is for: a tip that rests on a leaf which is to open.
    """
    k, x, u, _ = feedback()
    a, b = motion(LAG)
    true_a, true_b = motion(lag)
    n, m, kept = len(x), len(u), max(dead, believed, 1)
    # state: x, then the inputs sent 1, 2, … kept steps ago
    plan = np.zeros((m, n + kept * m))
    plan[:, :n] = k @ np.linalg.matrix_power(a, believed)
    for ago in range(1, believed + 1):
        plan[:, n + (ago - 1) * m : n + ago * m] = k @ np.linalg.matrix_power(a, ago - 1) @ b
    plan[1:3] *= gain
    loop = np.zeros((n + kept * m, n + kept * m))
    loop[:n, :n] = true_a
    if dead:
        loop[:n, n + (dead - 1) * m : n + dead * m] = true_b
    else:
        loop[:n] += true_b @ plan
    loop[n : n + m] = plan
    loop[n + m :, n:-m] = np.eye((kept - 1) * m)
    modes = np.linalg.eigvals(loop)
    return float(np.abs(modes[np.abs(np.angle(modes)) > SLOW]).max())


@pytest.mark.slow
@pytest.mark.parametrize("lag", [0.6, 1.0, 1.4])
@pytest.mark.parametrize("dead", [-2, 0, 2])
def test_a_loop_off_by_40_percent_and_40_ms_does_not_swing(lag: float, dead: int) -> None:
    assert growth(lag * LAG, DEAD + dead, 1.0) < 0.95


@pytest.mark.parametrize("gain", [0.5, 2.0])
def test_gain_margin_of_6_db_and_phase_margin(gain: float) -> None:
    """Half and twice the tilt that plans ask for; and twice the tilt with a step more of dead time, 30° at 4 Hz."""
    assert growth(LAG, DEAD, gain) < 0.95
    assert growth(LAG, DEAD + 1, gain) < 0.95


def test_a_plan_that_knows_of_dead_time_bears_more_of_it() -> None:
    """Three times the tilt behind 0.16 s of dead time: with 0.06 s of it believed the tip does not swing, with none it does."""
    assert growth(LAG, DEAD + 5, 3.0) < 0.97
    assert growth(LAG, DEAD + 5, 3.0, believed=0) > 1.0
