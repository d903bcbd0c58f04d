"""Kernels as numba's dispatchers: machine code is made of what Python calls, and nothing calls what is not there."""

from __future__ import annotations

import os
import runpy
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from llvmlite import ir
from numba.core import cgutils, types

from doorman.compilation import kernel
from doorman.numba_types.lanes import builtin

ROOT = Path(__file__).parents[2]

CHAIN = """
from doorman.compilation import kernel

@kernel
def inner(x):
    if x < 0.0:
        raise ValueError("negative")
    return 3.0 * x

@kernel
def middle(x):
    return inner(x) + inner(2.0 * x)

@kernel
def outer(x):
    return middle(x) - 1.0
"""
CALL = """
import sys
from doorman.compilation import kernel_counts
from doorman.compilation.machine_code import SelfContained
made = []
make = SelfContained._make
SelfContained._make = lambda library: (made.append(library.name), make(library))
import chain
print(*(getattr(chain, name)(1.0) for name in sys.argv[1:]), kernel_counts().compiled, *made)
try:
    getattr(chain, sys.argv[1])(-1.0)
except ValueError as error:
    print(error)
"""
PLAIN = """
import sys
if "doorman" in sys.argv:
    import doorman.compilation
import plain
for name in sys.argv[2:]:
    function = getattr(plain, name)
    print(name, function(1.0), sum(function.stats.cache_hits.values()))
"""
CACHED = """
import numba

@numba.njit(cache=True)
def called(x):
    return x + 1.0

@numba.njit(cache=True)
def one(x):
    return called(x) * 2.0

@numba.njit(cache=True)
def other(x):
    return called(x) * 3.0
"""


def run(code: str, folder: Path, *arguments: str) -> list[str]:
    """Lines that a process of its own prints."""
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], cwd=folder, capture_output=True, text=True, timeout=120, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(folder / "cache")},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_machine_code_is_made_of_what_python_calls_and_kept(tmp_path):
    """The figures: results, kernels compiled, libraries made or loaded."""
    (tmp_path / "chain.py").write_text(CHAIN)
    assert run(CALL, tmp_path, "outer") == ["8.0 3 outer", "negative"]
    assert run(CALL, tmp_path, "inner", "outer") == ["3.0 8.0 1 inner outer", "negative"]
    assert run(CALL, tmp_path, "outer", "inner") == ["8.0 3.0 0 outer inner", "negative"]


SHIFTED = """
from doorman.compilation import kernel

@kernel
def tripled(values):
    return 3.0 * values[::-1]

@kernel
def shifted(values):
    return tripled(values) + 1.0
"""


def test_a_kernel_that_others_call_is_called_from_python_later(tmp_path: Path) -> None:
    (tmp_path / "shifted.py").write_text(SHIFTED)  # of this run: no earlier one has left its kernels in the cache
    module = runpy.run_path(str(tmp_path / "shifted.py"))
    values, inner = np.arange(4.0), module["tripled"]
    np.testing.assert_array_equal(module["shifted"](values), [10.0, 7.0, 4.0, 1.0])
    (linked,) = inner.overloads.values()
    assert not inner.entries
    assert not callable(linked.entry_point)
    np.testing.assert_array_equal(inner(values), [9.0, 6.0, 3.0, 0.0])
    np.testing.assert_array_equal(inner(values), inner.py_func(values))
    assert len(inner.entries) == len(inner.overloads) == 1


@kernel
def _doubled(x: Any) -> Any:
    return 2 * x


def test_threads_may_call_a_kernel_for_the_first_time_together() -> None:
    given = [1, 1.0, 1j, np.float32(1.0)] * 4
    with ThreadPoolExecutor(8) as pool:
        results = list(pool.map(_doubled, given))
    assert results == [2 * each for each in given]
    assert len(_doubled.entries) == 4  # type: ignore[attr-defined]


@kernel
def _factorial(n: int) -> int:
    return 1 if n < 2 else n * _factorial(n - 1)


@kernel
def _is_even(n: int) -> bool:
    return True if n == 0 else _is_odd(n - 1)


@kernel
def _is_odd(n: int) -> bool:
    return False if n == 0 else _is_even(n - 1)


def test_kernels_may_call_themselves_and_each_other() -> None:
    assert _factorial(10) == 3628800
    assert [_is_even(n) for n in range(4)] == [True, False, True, False]
    assert [_is_odd(n) for n in range(4)] == [False, True, False, True]


@pytest.mark.slow
def test_kernels_that_call_each_other_are_compiled_by_every_process(tmp_path):
    """Their machine code holds an address of its process."""
    circle = "from doorman.compilation import kernel\n" + "".join(
        f"@kernel\ndef {name}(n):\n    return n if n <= 0 else {other}(n - 1)\n"
        for name, other in (("one", "two"), ("two", "one"))
    )
    (tmp_path / "chain.py").write_text(circle)
    code = "import chain\nfrom doorman.compilation import kernel_counts\nprint(chain.one(5), kernel_counts().compiled)"
    assert run(code, tmp_path) == run(code, tmp_path) == ["0 2"]


@builtin
def _nowhere(typingctx: Any, x: Any) -> Any:
    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = ir.FunctionType(ir.DoubleType(), [ir.DoubleType()])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, "function_that_nobody_defines"), args)

    return types.float64(types.float64), build


@kernel
def _calls_nothing(x: float) -> float:
    return _nowhere(x)


def test_a_call_of_nothing_is_an_error_and_no_crash() -> None:
    with pytest.raises(RuntimeError, match="nothing defines function_that_nobody_defines"):
        _calls_nothing(1.0)


@numba.njit
def _applied(function: Any, x: float) -> float:
    return function(x)


@numba.njit("float64(FunctionType(float64(float64)), float64)")
def _applied_by_address(function: Any, x: float) -> float:
    return function(x)


def test_kernels_are_arguments_by_name_but_no_addresses() -> None:
    assert _applied(_doubled, 4.0) == 8.0
    with pytest.raises(TypeError, match="_doubled"):
        _applied_by_address(_doubled, 4.0)


def test_other_compiled_functions_are_as_numba_makes_them() -> None:
    called_by_address = numba.cfunc("float64(float64)")(lambda x: 2.0 * x)
    assert called_by_address.ctypes(4.0) == 8.0
    halved = numba.vectorize(["float64(float64)"])(lambda x: 0.5 * x)
    np.testing.assert_array_equal(halved(np.arange(3.0)), [0.0, 0.5, 1.0])
    assert _applied_by_address(numba.njit("float64(float64)")(lambda x: x - 1.0), 4.0) == 3.0


@pytest.mark.slow
def test_numbas_own_cache_is_shared_with_programs_without_doorman(tmp_path):
    """The figures: results, and how often the cache had them."""
    (tmp_path / "plain.py").write_text(CACHED)
    assert run(PLAIN, tmp_path, "numba", "one") == ["one 4.0 0"]
    assert run(PLAIN, tmp_path, "doorman", "one", "other") == ["one 4.0 1", "other 6.0 0"]
    assert run(PLAIN, tmp_path, "numba", "other", "called") == ["other 6.0 1", "called 2.0 1"]
