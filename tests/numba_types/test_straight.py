"""Straight lines as kernels: what they compute, from all kinds of arguments, and that they are kept."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import doorman
from doorman.compilation import kernel
from doorman.numba_types.handles import held
from doorman.numba_types.straight import straight

Array = NDArray[np.float64]


class Numbers(NamedTuple):
    step: float
    count: int
    values: Array


@straight
def combine(numbers: Numbers, x: Array, out: Array) -> None:
    a = numbers.values[1] * x[0]
    s, c = sincos(a)  # type: ignore[name-defined]  # noqa: F821
    out[0, 0] = s + numbers.step / 2.0
    out[1, 2] = out[0, 1] = -c * numbers.count - 1.5


@straight
def area(x: Array) -> float:
    return 0.5 * x[0] * x[1]


@kernel
def through(numbers: Numbers, x: Array, out: Array) -> float:
    combine(numbers, x, out)
    return area(x[1:]) + 1.0


def test_numbers_of_tuples_handles_and_any_array() -> None:
    numbers, wide = Numbers(0.25, 3, np.array([5.0, 2.0])), np.array([[0.3, 9.0], [2.0, 9.0], [4.0, 9.0]])
    angle = 0.6
    expected = np.zeros((2, 3))
    expected[0, 0] = np.sin(angle) + 0.125
    expected[1, 2] = expected[0, 1] = -3.0 * np.cos(angle) - 1.5
    for given in (numbers, held(numbers)):
        for x in (wide[:, 0].copy(), wide[:, 0]):  # of its own, and every second number
            out, turned = np.zeros((2, 3)), np.zeros((3, 2)).T
            assert through(given, x, out) == area(x[1:]) + 1.0 == 5.0
            combine(given, x, turned)
            np.testing.assert_allclose(out, expected, rtol=1e-14)
            np.testing.assert_allclose(turned, expected, rtol=1e-14)


LINES = """
from doorman.numba_types.straight import straight

@straight
def double(x, out):
    out[0] = 2.0 * x[0]
"""

CALL = """
import numpy as np
from doorman.compilation import kernel_counts
from lines import double
out = np.zeros(1)
double(np.array([1.5]), out)
print(out[0], kernel_counts().compiled, kernel_counts().loaded)
"""


def test_another_process_loads_them(tmp_path: Path) -> None:
    (tmp_path / "lines.py").write_text(LINES)
    root = str(Path(doorman.__file__).parents[1])
    environment = {**os.environ, "PYTHONPATH": root, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    for counted in ("1 0", "0 1"):
        done = subprocess.run(
            [sys.executable, "-c", CALL], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=120, check=True
        )  # fmt: skip
        assert done.stdout.split() == ["3.0", *counted.split()]
