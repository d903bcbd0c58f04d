"""The tutorial runs as a reader would run it, says what it prints, and its example swings the pendulum up."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from tutorial import PAGE, tutorial

from doorman.ocp import PlanStatus

ROOT = Path(__file__).parents[3]


def test_every_block_runs_and_the_numbers_agree() -> None:
    page, text = tutorial(), PAGE.read_text(encoding="utf-8")
    assert len(re.findall(r"^```python$", text, re.MULTILINE)) == 8
    assert page.swung.states[-1, 0] == pytest.approx(np.pi + np.arcsin(0.1), abs=1e-3)
    assert page.swung.status is page.same.status is page.again.status is PlanStatus.CONVERGED
    np.testing.assert_allclose(page.same.states, page.swung.states, atol=1e-3)
    assert page.status is PlanStatus.ITERATION_LIMIT and page.states.shape == (61, 2)


def test_the_first_example_is_as_short_as_it_says() -> None:
    block = re.search(r"## Ten lines\n.*?```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL).group(1)
    assert len([line for line in block.splitlines() if line]) <= 10


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
