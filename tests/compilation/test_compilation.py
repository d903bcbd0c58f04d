"""Cache of compiled kernels: where it is, and that it notices every change and forgets nobody."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from llvmlite.binding import Linkage
from numpy.typing import NDArray

from doorman.compilation import cached_kernels, entry, kernel, kernel_counts

ROOT = Path(__file__).parents[2]

KERNEL = "@kernel\ndef f(x: float) -> float:\n    return x\n"

COPY = """
from doorman.ocp.solvers.iterations.filter import Filter, remember
pairs = Filter()
remember(pairs, 1.0, 2.0)
print(pairs.count, sum(remember.stats.cache_hits.values()))
"""


def test_two_copies_of_a_version_share_what_they_compile(tmp_path: Path) -> None:
    results = []
    for name in ("one", "two"):
        shutil.copytree(ROOT / "doorman", tmp_path / name / "doorman")
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(tmp_path / name)}
        done = subprocess.run(
            [sys.executable, "-c", COPY], env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=120
        )
        assert done.returncode == 0, done.stderr
        results.append(done.stdout.split())
    assert [hits for _, hits in results] == ["0", "1"]
    assert results[0][0] == results[1][0]


def fresh_directory() -> Path:
    return cached_kernels.cache_directory.__wrapped__()


def test_directory_follows_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    assert fresh_directory().parent == tmp_path / "xdg"
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "numba"))
    directory = fresh_directory()
    assert directory.parent == tmp_path / "numba"
    assert directory.name.startswith("doorman-")
    assert directory.is_dir()


def test_directory_changes_with_every_source_beside_a_kernel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    package = tmp_path / "package"
    (package / "solver").mkdir(parents=True)
    (package / "solver" / "kernels.py").write_text("from compilation import kernel\n\n" + KERNEL)
    (package / "solver" / "layout.py").write_text("class Numbers: ...\n")
    (package / "other.py").write_text('"""No @kernel in this one."""\n')
    monkeypatch.setattr(cached_kernels, "_PACKAGE", package)
    first = fresh_directory()
    (package / "other.py").write_text("changed = True\n")
    assert fresh_directory() == first
    (package / "solver" / "layout.py").write_text("class Numbers:\n    more: float\n")
    second = fresh_directory()
    (package / "solver" / "kernels.py").write_text(
        "from compilation import kernel\n\n" + KERNEL.replace("x\n", "2.0 * x\n")
    )
    third = fresh_directory()
    (package / "types.py").write_text("from numba.core.extending import overload\n")
    assert len({first, second, third, fresh_directory()}) == 4


@kernel
def _divide(a: float, b: float) -> float:
    return a / b


def test_nothing_hides_a_number_that_is_not_finite() -> None:
    assert _divide(1.0, 0.0) == np.inf
    assert np.isnan(_divide(0.0, 0.0))
    assert np.isnan(_divide(np.nan, 1.0))
    assert _divide.py_func(3.0, 2.0) == _divide(3.0, 2.0) == 1.5


def test_an_entry_is_compiled_before_its_first_call() -> None:
    divide = entry(_divide, 1.0, 1.0)
    before = kernel_counts()
    assert divide(3.0, 2.0) == 1.5 and divide(3, 2) == 1.5, "an integer is taken for a float"
    assert kernel_counts() == before
    with pytest.raises(TypeError):
        divide(None, 2.0)  # type: ignore[arg-type]


def test_a_kernel_runs_its_own_copies_of_what_it_calls() -> None:
    """Which of several copies runs is not left to the order in which a process compiles or loads them."""
    compiled: Any = numba.njit(_in_order)
    np.testing.assert_array_equal(compiled(np.array([3.0, 1.0, 2.0])), [1.0, 2.0, 3.0])
    (overload,) = compiled.overloads.values()
    functions = [each for each in overload.library._final_module.functions if not each.is_declaration]
    linkages = [function.linkage for function in functions]
    assert linkages.count(Linkage.internal) >= 2
    assert Linkage.linkonce_odr not in linkages


def _in_order(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.sort(values)


ADDER = """
from doorman.compilation import kernel

@kernel
def add(x, y):
    return x + 2.0 * y
"""

ADD = """
import resource, signal, sys
from doorman.compilation import kernel_counts
from adder import add
if len(sys.argv) > 1:
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))
print(add(1.0, 2.0), add(1, 2), kernel_counts().compiled)
"""


def add(folder: Path, *arguments: str, **environment: str) -> tuple[str, list[str]]:
    """Results and number of compiled kernels of a process of its own, and what it says on stderr."""
    done = subprocess.run(
        [sys.executable, "-c", ADD, *arguments], cwd=folder, capture_output=True, text=True, timeout=120, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(folder / "cache"), **environment},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout.strip(), done.stderr.splitlines()


def test_a_full_disk_and_a_damaged_cache_cost_a_warning(tmp_path: Path) -> None:
    (tmp_path / "adder.py").write_text(ADDER)
    found, (line,) = add(tmp_path, "full")
    assert found == "5.0 5.0 2" and "cannot be kept" in line
    assert not [path for path in (tmp_path / "cache").rglob("*") if path.is_file()]
    assert add(tmp_path) == ("5.0 5.0 2", [])
    for path in (tmp_path / "cache").rglob("*.nbc"):
        os.truncate(path, path.stat().st_size // 2)
    found, (line,) = add(tmp_path)
    assert found == "5.0 5.0 2" and "compiled anew" in line
    assert add(tmp_path) == ("5.0 5.0 0", [])


def test_without_a_compiler_a_command_says_so(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "doorman", "open", "paper", "--out", "run"], cwd=tmp_path, capture_output=True, text=True,
        timeout=120, env={**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_DISABLE_JIT": "1"}, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert "NUMBA_DISABLE_JIT" in line
    assert not list(tmp_path.iterdir())


def test_settings_that_change_the_code_have_a_directory_of_their_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    first = fresh_directory()
    monkeypatch.setattr(numba.config, "BOUNDSCHECK", 1)
    assert fresh_directory() != first
