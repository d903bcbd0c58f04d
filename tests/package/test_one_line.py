"""Reprs of results: one line that says what matters, arrays as shapes."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

from doorman.collision.scene import CollisionScene
from doorman.ocp import Hybrid, QuadraticCost
from doorman.one_line import OneLine
from doorman.planning.planner import Planner


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Everything(OneLine):
    """One field of every kind."""

    scalar: np.ndarray
    matrix: np.ndarray
    ratio: float
    words: str
    none: None
    several: tuple[int, ...]
    part: object


@pytest.fixture(scope="module")
def results(model) -> dict[str, object]:
    planner = Planner(model)
    problem = planner.planning.problem()
    solution = Hybrid(problem).solve(model.start_state)
    scene = CollisionScene(model.vehicle, model.door)
    clearances = scene.min_clearance_along(
        np.zeros((2, 3)) - 2.0, np.tile(np.eye(3), (2, 1, 1)), np.zeros((2, 4)), np.ones(2)
    )
    return {"plan": planner.plan(model.start_state), "problem": problem, "solution": solution, "cost": problem.cost,
            "bounds": problem.bounds, "clearances": clearances}  # fmt: skip


def test_every_result_is_one_line(results):
    for result in results.values():
        text = repr(result)
        assert "\n" not in text and len(text) < 400, text
        assert re.match(rf"{type(result).__name__}\(\w+=", text) and text.endswith(")")
        for field in dataclasses.fields(result):
            assert f"{field.name}=" in text


def test_a_repr_says_what_matters(results):
    plan, solution = results["plan"], results["solution"]
    for word in ("status=CONVERGED", "states=array(51, 9)", f"cost={plan.cost:.6g}", "max_violation=", "iterations="):
        assert word in repr(plan)
    for word in ("problem=Problem(…)", f"cost={solution.cost:.6g}", "status=CONVERGED", "gains=array(50, 8, 9)"):
        assert word in repr(solution)
    for word in ("horizon=50", "time_step=0.02", "cost=QuadraticCost(…)", "n_constraints="):
        assert word in repr(results["problem"])


def test_every_kind_of_value_is_short():
    part = QuadraticCost(*np.ones((5, 1)))
    text = repr(Everything(np.array(1.0), np.zeros((3, 4)), 1 / 3, "a\nb" * 99, None, (1, 2, 3), part))
    assert text.startswith("Everything(scalar=array(), matrix=array(3, 4), ratio=0.333333, words='a\\nb")
    assert text.endswith("…, none=None, several=tuple of 3, part=QuadraticCost(…))")
    assert "\n" not in text
