"""What the measured attitude loop is judged by: how late it follows in all, as far as that is sure."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.control.estimation.loop_fit import MeasuredLoop
from doorman.control.estimation.loop_test import LoopTest
from doorman.model import Model

MODEL = Model("push")


def judged(lag: float, dead: float, doubt: float = 0.003) -> str:
    test, doubts = LoopTest(MODEL), np.full(2, doubt)
    test.measured = MeasuredLoop(np.array([lag, 0.1]), np.array([dead, 0.02]), doubts, doubts, np.ones(2))
    return test.unfit()


@pytest.mark.parametrize(("lag", "dead"), [(0.1, 0.05), (0.2, 0.1), (0.15, 0.18), (0.25, 0.1)])
def test_a_loop_whose_shape_differs_counts_by_all_that_it_is_late(lag: float, dead: float) -> None:
    assert judged(lag, dead) == ""


@pytest.mark.parametrize(("lag", "dead", "advice"), [(0.3, 0.02, "MC_ROLL_P"), (0.2, 0.2, "line to the autopilot")])
def test_one_that_is_later_than_any_that_was_flown_is_refused(lag: float, dead: float, advice: str) -> None:
    assert f"roll follows {1e3 * (lag + dead):.0f} ms behind" in judged(lag, dead) and advice in judged(lag, dead)


def test_a_measurement_that_is_not_sure_refuses_nothing() -> None:
    assert judged(0.27, 0.1) != "" and judged(0.27, 0.1, doubt=0.02) == ""
