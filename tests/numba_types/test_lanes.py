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
from doorman.numba_types.elementary import larger, sincos, square_root, tanh
from doorman.numba_types.lanes import broadcast, get, lane, load, put, store, zero
from doorman.numba_types.matrix_rows import multiply_rows

Array = NDArray[np.float64]
WIDTHS = (2, 4, 8, 16)
HARD = (0.0, -0.0, 1e-320, math.inf, -math.inf, math.nan, math.pi / 2, -math.pi / 2, 1e-9, 99_999.0)
"""Numbers that are easily got wrong."""


@kernel
def _functions(numbers: Array, lanes: tuple[int, ...], out: Array) -> None:
    """Every function of one number: lanes of a row if there are any."""
    x = get(numbers, 0, lanes)
    sine, cosine = sincos(x)
    put(out, 0, sine)
    put(out, 1, cosine)
    put(out, 2, square_root(x))
    put(out, 3, tanh(x))
    put(out, 4, larger(x, 0.25))
    put(out, 5, -x)
    put(out, 6, zero(lanes) + x)


def by_lanes(numbers: Array, width: int) -> Array:
    """`_functions` of a multiple of `width` numbers, side by side."""
    out = np.empty((7, len(numbers)))
    for first in range(0, len(numbers), width):
        some, results = np.ascontiguousarray(numbers[None, first : first + width]), np.empty((7, width))
        _functions(some, (0,) * width, results)
        out[:, first : first + width] = results
    return out


def one_by_one(numbers: Array) -> Array:
    out = np.empty((len(numbers), 7))
    for number, results in zip(numbers, out, strict=True):
        _functions(np.array([number]), (), results)
    return out.T


@pytest.fixture
def numbers(rng: np.random.Generator) -> Array:
    large = 10.0 ** rng.uniform(-6.0, 5.0, 470) * rng.choice([-1.0, 1.0], 470)
    near_poles = (math.pi / 2) * np.arange(-80.0, 80.0) + rng.choice([-1e-9, 0.0, 1e-9], 160)
    return np.concatenate([large, near_poles, HARD])


@pytest.mark.parametrize("width", WIDTHS)
def test_lanes_and_numbers_get_the_same_bits(numbers: Array, width: int) -> None:
    np.testing.assert_array_equal(by_lanes(numbers, width), one_by_one(numbers))


def test_functions_equal_numpys(numbers: Array) -> None:
    sine, cosine, root, tangent, larger_one, negative, same = by_lanes(numbers, 8)
    with np.errstate(invalid="ignore"):
        np.testing.assert_allclose(sine, np.sin(numbers), rtol=0.0, atol=2.3e-16)
        np.testing.assert_allclose(cosine, np.cos(numbers), rtol=0.0, atol=2.3e-16)
        np.testing.assert_array_equal(root, np.sqrt(numbers))
        np.testing.assert_allclose(tangent, np.tanh(numbers), rtol=5e-16)
    np.testing.assert_array_equal(larger_one, np.where(np.isnan(numbers), np.nan, np.fmax(numbers, 0.25)))
    np.testing.assert_array_equal(negative, -numbers)
    np.testing.assert_array_equal(np.signbit(negative), ~np.signbit(numbers))
    np.testing.assert_array_equal(same, numbers)


def test_sine_and_cosine_over_their_whole_range(rng: np.random.Generator) -> None:
    """One unit in the last place of 1, for |x| < 1e5."""
    numbers = rng.uniform(-1e5, 1e5, 80_000)
    sine, cosine = by_lanes(numbers, 16)[:2]
    assert np.abs(sine - np.sin(numbers)).max() <= 2.3e-16
    assert np.abs(cosine - np.cos(numbers)).max() <= 2.3e-16
    assert np.abs(sine**2 + cosine**2 - 1.0).max() <= 5e-16


def test_small_angles_keep_their_digits() -> None:
    numbers = 10.0 ** -np.arange(1.0, 17.0)
    np.testing.assert_allclose(by_lanes(numbers, 16)[0], np.sin(numbers), rtol=3e-16)


@kernel
def _arithmetic(x: Array, y: Array, number: float, whole: int, lanes: tuple[int, ...], out: Array) -> None:
    a, b = load(x, 0, lanes), load(y, 0, lanes)
    store(out, (0, 0), a + b)
    store(out, (1, 0), a - b)
    store(out, (2, 0), a * b)
    store(out, (3, 0), a / b)
    store(out, (4, 0), a + number)
    store(out, (5, 0), number - a)
    store(out, (6, 0), a * whole)
    store(out, (7, 0), whole / a)
    c = a
    c += b
    store(out, (8, 0), c)
    c = a
    c -= number
    store(out, (9, 0), c)
    c = a
    c *= whole
    store(out, (10, 0), c)
    c = a
    c /= b
    store(out, (11, 0), c)
    store(out, (12, 0), broadcast(number, lanes))
    store(out, (13, 0), broadcast(whole, lanes) * b)


@pytest.mark.parametrize("width", WIDTHS)
def test_arithmetic_of_lanes_floats_and_integers(width: int, rng: np.random.Generator) -> None:
    x, y, out = rng.normal(size=width), rng.normal(size=width), np.empty((14, width))
    x[0], y[0], x[1] = 0.0, 0.0, math.inf
    _arithmetic(x, y, 0.3, 7, (0,) * width, out)
    with np.errstate(divide="ignore", invalid="ignore"):
        expected = [
            x + y, x - y, x * y, x / y, x + 0.3, 0.3 - x, x * 7, 7 / x, x + y, x - 0.3, x * 7, x / y,
            np.full(width, 0.3), 7.0 * y,
        ]  # fmt: skip
    np.testing.assert_array_equal(out, expected)


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
def _copy(source: Array, target: Array, lanes: tuple[int, ...]) -> None:
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            put(target, (j, i), 2.0 * get(source, (i, j), lanes))


def test_get_and_put_take_numbers_or_lanes_along_the_last_axis(rng: np.random.Generator) -> None:
    many, one = rng.normal(size=(3, 5, 8)), rng.normal(size=(3, 5))
    many_copied, one_copied = np.zeros((5, 3, 8)), np.zeros((5, 3))
    _copy(many, many_copied, (0,) * 8)
    _copy(one, one_copied, ())
    np.testing.assert_array_equal(many_copied, 2.0 * many.transpose(1, 0, 2))
    np.testing.assert_array_equal(one_copied, 2.0 * one.T)


@kernel
def _sum_of_lanes(x: Array, lanes: tuple[int, ...]) -> float:
    """Lanes one by one, by indices of two kinds."""
    value, total = load(x, 0, lanes), 0.0
    for i in range(len(lanes)):
        total += lane(value, i)
    return float(total + 10.0 * lane(value, np.int32(1)))


def test_single_lanes() -> None:
    assert _sum_of_lanes(np.array([1.0, 2.0, 4.0, 8.0]), (0,) * 4) == 35.0


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


def test_plain_python_has_the_same_functions() -> None:
    """Outside of kernels the functions take numbers."""
    assert sincos(0.3) == (np.sin(0.3), np.cos(0.3))
    assert square_root(2.0) == math.sqrt(2.0)
    assert larger(1.0, 2.0) == 2.0 and math.isnan(larger(math.nan, 2.0))
    assert tanh(0.5) == np.tanh(0.5)
    assert zero(()) == 0.0
    numbers = np.arange(6.0).reshape(2, 3)
    put(numbers, (1, 2), get(numbers, (0, 1), ()))
    assert numbers[1, 2] == 1.0
