"""Every kernel against its plain twin: whole plans, with and without the compiler.

The twin of a kernel is the Python function that it is compiled from, run by Python, which checks every index and has no
instruction of a processor's vectors; `uncompiled` gives plain bodies to what is written as machine code.
"""

from __future__ import annotations

import functools
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

HERE = Path(__file__).parent
PATHS = (HERE, HERE.parents[1] / "helpers", HERE.parent / "toys")
PACKAGES = ("doorman.ocp.", "doorman.dynamics.", "doorman.kinematics.", "doorman.collision.")
ELSEWHERE = {
    "doorman.ocp.kernels.default_curvature.": "tests/ocp/symbolic/test_curvature.py: against CasADi",
    "doorman.ocp.kernels.runtime.": "tests/ocp/symbolic/test_curvature.py: Hessians that printed modules make positive",
    "doorman.ocp.kernels.defaults.": "tests/ocp/kernels/test_defaults.py: each against derivatives by hand",
    "doorman.ocp.kernels.compiled_model.": "nothing but calls of a model's functions, which run without a table here",
    "doorman.ocp.solvers.iterations.correction.pass_over_equalities": "tests/ocp/search/test_equalities.py",
    "doorman.ocp.solvers.sweeps.full_weights.": "tests/ocp/search/system.py: against IPOPT",
    "doorman.kinematics.vehicles.arms.arm.": "tests/kinematics: Pinocchio",
}
"""Kernels that no plan runs, and where they are compared."""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], Any]:
    """What `plans.py` writes."""

    @functools.cache
    def written(compiler: str, which: str) -> Any:
        file = tmp_path_factory.mktemp(compiler) / f"{which}.json"
        first = "import uncompiled, plans" if compiler == "uncompiled" else "import plans"
        command = [sys.executable, "-c", f"{first}; plans.write({which!r}, {str(file)!r})"]
        path = os.pathsep.join([*map(str, PATHS), os.environ.get("PYTHONPATH", "")])
        environment = {
            **os.environ,
            "PYTHONPATH": path,
            "NUMBA_DISABLE_JIT": "0",
        }  # uncompiled switches it off by itself
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr
        return json.loads(file.read_text())

    return written


def compare(plain: Any, compiled: Any, tolerance: float) -> None:
    """The same decisions, and the same numbers."""
    assert plain["plans"].keys() == compiled["plans"].keys() and plain["plans"]
    for name, plan in plain["plans"].items():
        other = compiled["plans"][name]
        assert (plan["status"], plan["iterations"]) == (other["status"], other["iterations"]), name
        for field in ("states", "inputs"):
            np.testing.assert_allclose(plan[field], other[field], rtol=0.0, atol=tolerance, err_msg=name)


@pytest.mark.slow
def test_door_plans_are_those_of_plain_python(run: Callable[[str, str], Any]) -> None:
    plain = run("uncompiled", "doors")
    compare(plain, run("compiled", "doors"), 1e-11)
    assert len({plan["status"] for plan in plain["plans"].values()}) >= 3  # easy ones would prove little


@pytest.mark.slow
def test_toys_are_solved_as_by_plain_python(run: Callable[[str, str], Any]) -> None:
    """Derivatives by differences take up more of the last bits."""
    compare(run("uncompiled", "toys"), run("compiled", "toys"), 1e-7)


@pytest.mark.slow
def test_every_kernel_has_run_plainly(run: Callable[[str, str], Any]) -> None:
    runs = [run("uncompiled", which)["called"] for which in ("doors", "toys")]
    never = {name for name in runs[0] if name.startswith(PACKAGES) and not any(called[name] for called in runs)}
    unexplained = {name for name in never if not name.startswith(tuple(ELSEWHERE))}
    assert not unexplained
    assert all(any(name.startswith(known) for name in never) for known in ELSEWHERE)  # nothing is excused in vain
