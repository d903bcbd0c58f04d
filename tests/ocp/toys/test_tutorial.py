"""The tutorial runs as a reader would run it, says what it prints, and its example swings the pendulum up."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from tutorial import PAGE, tutorial

from doorman import ocp
from doorman.compilation import kernel_counts
from doorman.exceptions import DimensionError
from doorman.ocp import PlanStatus, functions

ROOT = Path(__file__).parents[3]


@pytest.mark.slow
def test_every_block_runs_and_the_numbers_agree() -> None:
    page, text = tutorial(), PAGE.read_text(encoding="utf-8")
    assert len(re.findall(r"^```python$", text, re.MULTILINE)) == 9
    assert page.swung.states[-1, 0] == pytest.approx(np.pi + np.arcsin(0.1), abs=1e-3)
    assert page.swung.status is page.same.status is page.again.status is PlanStatus.CONVERGED
    np.testing.assert_allclose(page.same.states, page.swung.states, atol=1e-3)
    assert page.status is PlanStatus.ITERATION_LIMIT and page.states.shape == (61, 2)


def test_the_first_example_is_as_short_as_it_says() -> None:
    block = re.search(r"## Ten lines\n.*?```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL).group(1)
    assert len([line for line in block.splitlines() if line]) <= 10


@pytest.mark.docs
def test_the_example_runs() -> None:
    path = ROOT / "examples" / "ocp_pendulum.py"
    ran = subprocess.run(
        [sys.executable, str(path)], cwd=ROOT, capture_output=True, text=True, timeout=300, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    assert "converged" in ran.stdout
    end = float(re.search(r"ended at ([\d.]+)°", ran.stdout).group(1))
    assert end == pytest.approx(180.0, abs=5.0)
    assert float(re.search(r"stayed (-?[\d.]+) m clear", ran.stdout).group(1)) >= 0.0
    assert len(path.read_text(encoding="utf-8").splitlines()) < 60


def test_parameters_belong_to_a_solver_and_compile_nothing() -> None:
    pendulum = tutorial(1).pendulum
    first, second = ocp.Hybrid(pendulum), ocp.Hybrid(pendulum)
    before, counts = first.solve([0.0, 0.0]), kernel_counts()
    first.update_parameters([0.2])
    after = first.solve([0.0, 0.0])
    assert after.cost < before.cost and after.problem.model.parameters.tolist() == [0.2]
    assert second.solve([0.0, 0.0]).cost == before.cost and pendulum.model.parameters.tolist() == [0.1]
    assert kernel_counts() == counts
    with pytest.raises(DimensionError, match="parameters"):
        first.update_parameters([0.1, 0.2])


def test_another_model_of_the_same_sizes_has_kernels_of_its_own() -> None:
    """Types of generated models share a name and a layout."""
    x, u, p = ca.SX.sym("x", 2), ca.SX.sym("u"), ca.SX.sym("p")
    other = ocp.SymbolicModel(x, u, ca.vertcat(x[1], u), parameters=p)
    problem = other.problem(60, 0.05, tutorial(1).lean, parameters=[0.1], constraints=[ocp.Constraint("c", x[1] - p)])
    ahead, swung = np.zeros(2), np.zeros(2)
    for model, out in ((problem.model, ahead), (tutorial(1).pendulum.model, swung)):
        functions.step(functions.at_node(model, 0), np.array([1.0, 0.5]), np.array([2.0]), out)
    assert ahead == pytest.approx([1.0 + 0.05 * 0.5 + 0.00125 * 2.0, 0.6]) and abs(swung[1] - 0.6) > 0.1


def test_replanning_follows_and_comes_back_after_jumps() -> None:
    solver, fresh = ocp.Hybrid(tutorial(1).pendulum), ocp.Hybrid(tutorial(1).pendulum)
    state, random = np.zeros(2), np.random.default_rng(2)
    for k in range(30):
        status, _ = solver.replan(state, elapsed=0.05)
        assert status.usable
        state = solver.trajectory()[0][1] + (random.uniform(-0.5, 0.5, 2) if k % 10 == 9 else 0.0)
    for _ in range(5):
        status, _ = solver.replan(state, elapsed=0.0)
    best = fresh.solve(state, solver.trajectory()[1])
    assert status.usable and solver.cost <= best.cost * (1.0 + 1e-3) + 1e-6
