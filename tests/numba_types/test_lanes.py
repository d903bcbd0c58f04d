# ruff: noqa: F821
# mypy: disable-error-code="name-defined"
"""Vectors of doubles in compiled code, against numpy: the same functions on one number and on many, bit for bit."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.numba_types.clock import clock
from doorman.numba_types.elementary import sincos
from doorman.numba_types.lanes import load, store, zero
from doorman.numba_types.matrix_rows import multiply_rows
from doorman.numba_types.straight import straight

Array = NDArray[np.float64]
LANES = (0,) * 8
HARD = (0.0, -0.0, 1e-320, math.inf, -math.inf, math.nan, math.pi / 2, -math.pi / 2, 1e-9, 99_999.0)
"""Numbers that are easily got wrong."""


@straight
def _of_number(x: Array, out: Array) -> None:
    out[0], out[1] = sincos(x[0])
    out[2] = square_root(x[0])
    out[3] = tanh(x[0])
    out[4] = larger(x[0], 0.25)
    out[5] = -x[0]


@straight
def _of_lanes(x: Array, out: Array) -> None:
    value = get(x, 0, LANES)
    sine, cosine = sincos(value)
    put(out, 0, sine)
    put(out, 1, cosine)
    put(out, 2, square_root(value))
    put(out, 3, tanh(value))
    put(out, 4, larger(value, 0.25))
    put(out, 5, -value)


def by_lanes(numbers: Array) -> Array:
    """Every function of one number, of a multiple of eight numbers side by side."""
    out = np.empty((6, len(numbers)))
    for first in range(0, len(numbers), 8):
        results = np.empty((6, 8))
        _of_lanes(np.ascontiguousarray(numbers[None, first : first + 8]), results)
        out[:, first : first + 8] = results
    return out


@pytest.fixture
def numbers(rng: np.random.Generator) -> Array:
    large = 10.0 ** rng.uniform(-6.0, 5.0, 470) * rng.choice([-1.0, 1.0], 470)
    near_poles = (math.pi / 2) * np.arange(-80.0, 80.0) + rng.choice([-1e-9, 0.0, 1e-9], 160)
    return np.concatenate([large, near_poles, HARD])


def test_lanes_and_numbers_get_the_same_bits(numbers: Array) -> None:
    alone = np.empty((len(numbers), 6))
    for number, results in zip(numbers, alone, strict=True):
        _of_number(np.array([number]), results)
    np.testing.assert_array_equal(by_lanes(numbers), alone.T)


@kernel
def _in_a_kernel(x: float) -> tuple[float, float]:
    return sincos(x)


def test_functions_equal_numpys(numbers: Array) -> None:
    sine, cosine, root, tangent, larger_one, negative = by_lanes(numbers)
    with np.errstate(invalid="ignore"):
        np.testing.assert_allclose(sine, np.sin(numbers), rtol=0.0, atol=2.3e-16)
        np.testing.assert_allclose(cosine, np.cos(numbers), rtol=0.0, atol=2.3e-16)
        np.testing.assert_array_equal(root, np.sqrt(numbers))
        np.testing.assert_allclose(tangent, np.tanh(numbers), rtol=5e-16)
    np.testing.assert_array_equal(larger_one, np.where(np.isnan(numbers), np.nan, np.fmax(numbers, 0.25)))
    np.testing.assert_array_equal(negative, -numbers)
    np.testing.assert_array_equal(np.signbit(negative), ~np.signbit(numbers))
    for number, of_lanes in zip(numbers[:50], zip(sine, cosine, strict=True), strict=False):
        assert _in_a_kernel(number) == of_lanes
    assert sincos(0.3) == (np.sin(0.3), np.cos(0.3)), "outside of kernels"


def test_sine_and_cosine_over_their_whole_range(rng: np.random.Generator) -> None:
    """One unit in the last place of 1, for |x| < 1e5; small angles keep their digits."""
    numbers = rng.uniform(-1e5, 1e5, 80_000)
    sine, cosine = by_lanes(numbers)[:2]
    assert np.abs(sine - np.sin(numbers)).max() <= 2.3e-16
    assert np.abs(cosine - np.cos(numbers)).max() <= 2.3e-16
    assert np.abs(sine**2 + cosine**2 - 1.0).max() <= 5e-16
    small = 10.0 ** -np.arange(1.0, 17.0)
    np.testing.assert_allclose(by_lanes(small)[0], np.sin(small), rtol=3e-16)


@kernel
def _arithmetic(x: Array, y: Array, number: float, lanes: tuple[int, ...], out: Array) -> None:
    a, b = load(x, 0, lanes), load(y, 0, lanes)
    store(out, (0, 0), a + b)
    store(out, (1, 0), a - b)
    store(out, (2, 0), a * b)
    store(out, (3, 0), a + number)
    store(out, (4, 0), number - a)
    c = zero(lanes)
    c += number * b
    store(out, (5, 0), c)


@pytest.mark.parametrize("width", [2, 4, 8, 16])
def test_arithmetic_of_lanes_and_floats(width: int, rng: np.random.Generator) -> None:
    x, y, out = rng.normal(size=width), rng.normal(size=width), np.empty((6, width))
    x[0], x[1] = 0.0, math.inf
    _arithmetic(x, y, 0.3, (0,) * width, out)
    np.testing.assert_array_equal(out, [x + y, x - y, x * y, x + 0.3, 0.3 - x, 0.3 * y])


@kernel
def _move(source: Any, target: Any, lanes: tuple[int, ...], i: int, j: int) -> None:
    store(target, (j, i), load(source, (i, j), lanes))


def test_loads_and_stores_begin_anywhere(rng: np.random.Generator) -> None:
    """Places that are not multiples of the width; what is beside them stays."""
    source = rng.normal(size=(6, 21))
    for i in range(6):
        for j in range(12):
            target = np.zeros((14, 16))
            _move(source, target, (0,) * 8, i, j)
            expected = np.zeros((14, 16))
            expected[j, i : i + 8] = source[i, j : j + 8]
            np.testing.assert_array_equal(target, expected)


@kernel
def _multiply(matrix: Array, block: int, rows: Any, width: Any, vector: Array, out: Array, start: int) -> None:
    multiply_rows(matrix, block, rows, width, vector, out, start)


@pytest.mark.parametrize(("rows", "width"), [(1, 8), (5, 8), (9, 24)])
def test_product_of_rows_with_a_vector(rows: int, width: int, rng: np.random.Generator) -> None:
    matrix, vector = rng.normal(size=(4, rows, width)), rng.normal(size=width + 3)
    for block in (0, 3):
        out = np.zeros(rows + 4)
        _multiply(matrix, block, (0,) * rows, (0,) * width, vector, out, 2)
        np.testing.assert_allclose(out[2 : 2 + rows], matrix[block] @ vector[:width], rtol=1e-14, atol=1e-14)
        assert not out[:2].any() and not out[2 + rows :].any()


def test_a_product_may_overwrite_its_vector(rng: np.random.Generator) -> None:
    """As the step of a sweep does: the vector is read before anything is written."""
    matrix, vector = rng.normal(size=(1, 5, 8)), rng.normal(size=8)
    expected = matrix[0] @ vector
    _multiply(matrix, 0, (0,) * 5, (0,) * 8, vector, vector, 0)
    np.testing.assert_allclose(vector[:5], expected, rtol=1e-14, atol=1e-14)


@kernel
def _now() -> float:
    return float(clock())


def test_clock_is_the_monotonic_one() -> None:
    for _ in range(100):
        before, now, after = time.monotonic(), _now(), time.monotonic()
        assert before <= now <= after
