"""Handles: kernels read a NamedTuple behind a pointer as they would the NamedTuple itself."""

from __future__ import annotations

import copy
import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np
import pytest
from numpy.typing import NDArray

import doorman
from doorman.compilation import kernel
from doorman.numba_types.handles import Handle, HandleType, held, separate
from doorman.ocp.kernels import functions

Array = NDArray[np.float64]


class Inner(NamedTuple):
    scale: float
    rows: Array


class Middle(NamedTuple):
    inner: Inner
    flags: NDArray[np.bool_]
    sizes: tuple[int, ...]


class Outer(NamedTuple):
    count: int
    middle: Middle
    vector: Array
    pair: tuple[float, int]
    sides: NDArray[np.int8]


def content(rng: np.random.Generator, rows: int = 3) -> Outer:
    inner = Inner(rng.normal(), rng.normal(size=(rows, 4)))
    middle = Middle(inner, rng.random(4) < 0.5, (0,) * 5)
    return Outer(7, middle, rng.normal(size=4), (rng.normal(), 3), np.array([1, -1, 0, 1], dtype=np.int8))


@functions.implement(functions.step, Outer)
@kernel
def _step(outer: Outer, x: Array, u: Array, out: Array) -> None:
    out[0] = outer.count


@kernel
def _inner_sum(inner: Inner, by: Array) -> float:
    total = 0.0
    for i in range(inner.rows.shape[0]):
        for j in range(inner.rows.shape[1]):
            total += inner.scale * inner.rows[i, j] * by[j]
    return total


@kernel
def _digest(outer: Outer, out: Array) -> None:
    """Reads a field of every kind, at every depth, and writes to the arrays."""
    out[0] = _inner_sum(outer.middle.inner, outer.vector)
    out[1] = outer.count + len(outer.middle.sizes)
    out[2] = outer.pair[0] * outer.pair[1]
    for i in range(4):
        out[3 + i] = outer.sides[i] if outer.middle.flags[i] else 0.5
    middle = outer.middle
    middle.inner.rows[0, 0] += 1.0
    outer.vector[:] = outer.vector[::-1].copy()
    middle.flags[0] = not middle.flags[0]
    outer.sides[1] = 5


def plain_digest(outer: Outer) -> Array:
    inner = outer.middle.inner
    return np.array([
        inner.scale * (inner.rows @ outer.vector).sum(), outer.count + len(outer.middle.sizes),
        outer.pair[0] * outer.pair[1], *np.where(outer.middle.flags, outer.sides, 0.5),
    ])  # fmt: skip


def arrays_of(outer: Outer) -> list[Array]:
    return [outer.middle.inner.rows, outer.middle.flags, outer.vector, outer.sides]


def test_a_kernel_reads_and_writes_what_is_held(rng: np.random.Generator) -> None:
    """Also where nothing else refers to the arrays: memory that was let go would be used again by the crowd."""
    outer, out = content(rng), np.empty(7)
    expected, rows = plain_digest(outer), outer.middle.inner.rows.copy()
    vector, flag = outer.vector.copy(), outer.middle.flags[0]
    alone, again = held(content(np.random.default_rng(3))), np.empty(7)
    crowd = [np.full((3, 4), np.nan) for _ in range(1000)]
    _digest(alone, again)
    np.testing.assert_allclose(again, plain_digest(content(np.random.default_rng(3))), rtol=1e-12)
    assert len(crowd) == 1000
    _digest(held(outer), out)
    np.testing.assert_allclose(out, expected, rtol=1e-12)
    assert outer.middle.inner.rows[0, 0] == rows[0, 0] + 1.0
    np.testing.assert_array_equal(outer.vector, vector[::-1])
    assert outer.middle.flags[0] != flag
    assert outer.sides[1] == 5


def test_numbers_are_as_they_were_and_arrays_as_they_are(rng: np.random.Generator) -> None:
    outer, out = content(rng), np.empty(7)
    handle = held(outer)
    outer.vector[:] = [1.0, 2.0, 3.0, 4.0]
    expected = plain_digest(outer)
    _digest(handle, out)
    np.testing.assert_allclose(out, expected, rtol=1e-12)


def test_replace_takes_other_numbers_and_arrays_of_other_lengths(rng: np.random.Generator) -> None:
    first, second = content(rng), content(rng, rows=9)._replace(count=-2)
    handle, out = Handle(first), np.empty(7)
    _digest(handle, out)
    before = [array.copy() for array in arrays_of(first)]
    handle.replace(second)
    assert handle.content is second
    expected = plain_digest(second)
    _digest(handle, out)
    np.testing.assert_allclose(out, expected, rtol=1e-12)
    for array, kept in zip(arrays_of(first), before, strict=True):
        np.testing.assert_array_equal(array, kept)


def test_two_handles_of_one_type_share_their_kernel(rng: np.random.Generator) -> None:
    out = np.empty(7)
    _digest(held(content(rng)), out)
    known = len(_digest.signatures)  # type: ignore[attr-defined]
    _digest(held(content(rng, rows=5)), out)
    assert len(_digest.signatures) == known  # type: ignore[attr-defined]


@kernel
def _unknown_field(outer: Any) -> float:
    return float(outer.nothing)


def test_an_unknown_field_does_not_compile(rng: np.random.Generator) -> None:
    with pytest.raises(Exception, match="nothing"):
        _unknown_field(held(content(rng)))


MODULE = """
from typing import NamedTuple
import numpy as np
from doorman.compilation import kernel
from doorman.ocp.kernels import functions

class {name}(NamedTuple):
    factor: float
    memory: np.ndarray

@functions.implement(functions.step, {name})
@kernel
def _step(model, x, u, out):
    out[0] = x[0] + {factor} * model.factor * u[0] + model.memory[0]
"""
SOLVER = """
from doorman.compilation import kernel
from doorman.ocp.kernels.functions import step

@kernel
def twice(model, x, u, out):
    step(model, x, u, out)
    x[0] = out[0]
    step(model, x, u, out)
"""
RUN = """
import numpy as np
from {module} import {name}
from doorman.compilation import kernel_counts
from doorman.numba_types.handles import held
from solver import twice
out = np.zeros(1)
twice(held({name}(1.0, np.zeros(2))), np.zeros(1), np.ones(1), out)
print(out[0], twice.stats.cache_hits and 1 or 0)
"""


def run(folder: Path, module: str, name: str) -> tuple[float, bool]:
    """Result of a kernel with a user's model behind a handle, in a process of its own, and whether it was in the cache."""
    path = [str(folder), str(Path(doorman.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    environment = {
        **os.environ, "NUMBA_CACHE_DIR": str(folder / "cache"), "PYTHONPATH": os.pathsep.join(path),
        "PYTHONDONTWRITEBYTECODE": "1",
    }  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-c", RUN.format(module=module, name=name)], env=environment, cwd=folder, capture_output=True,
        text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    result, hits = done.stdout.split()
    return float(result), hits == "1"


def test_kernels_with_handles_are_cached_and_follow_the_source_behind_them(tmp_path: Path) -> None:
    """Also for who cannot import the model of somebody else: its kernels are kept apart."""
    (tmp_path / "solver.py").write_text(SOLVER)
    rail = tmp_path / "rail.py"
    rail.write_text(MODULE.format(name="Rail", factor=1.0))
    assert run(tmp_path, "rail", "Rail") == (2.0, False)
    assert run(tmp_path, "rail", "Rail") == (2.0, True)
    rail.write_text(MODULE.format(name="Rail", factor=3.0))
    assert run(tmp_path, "rail", "Rail") == (6.0, False)
    rail.unlink()
    (tmp_path / "wheel.py").write_text(MODULE.format(name="Wheel", factor=5.0))
    assert run(tmp_path, "wheel", "Wheel") == (10.0, False)


@pytest.mark.parametrize(
    "make", [copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))], ids=["deepcopy", "pickle"]
)
def test_a_copy_has_memory_of_its_own_and_shares_arrays_as_the_original_did(make, rng: np.random.Generator) -> None:
    outer, out = content(rng), np.empty(7)
    expected = plain_digest(outer)
    handle = Handle(outer)
    copied, arrays = make((handle, outer))
    assert copied.address != handle.address
    assert copied.content is arrays
    before = [array.copy() for array in arrays_of(outer)]
    _digest(copied, out)
    np.testing.assert_allclose(out, expected, rtol=1e-12)
    for array, kept in zip(arrays_of(outer), before, strict=True):
        np.testing.assert_array_equal(array, kept)
    assert arrays.sides[1] == 5


def test_a_separate_one_has_the_same_values_and_no_array_in_common(rng: np.random.Generator) -> None:
    outer = content(rng)
    other = separate(outer)
    assert type(other) is Outer
    assert plain_digest(other).tolist() == plain_digest(outer).tolist()
    assert not any(np.shares_memory(a, b) for a, b in zip(arrays_of(outer), arrays_of(other), strict=True))


def test_models_of_one_name_and_layout_in_two_modules_are_two_types() -> None:
    """Else a solver would run the kernels of the model that it met first."""
    first, second = (NamedTuple("Model", [("factor", float)]) for _ in range(2))
    first.__module__, second.__module__ = "one", "other"
    types = [HandleType(numba.typeof(kind(1.0))) for kind in (first, second, first)]
    assert types[0] != types[1] and types[0] == types[2]
