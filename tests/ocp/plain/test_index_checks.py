"""Whole plans by kernels that check every index, which they usually do not: nothing is read or written beyond an array."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

HERE = Path(__file__).parent
PATHS = (HERE, HERE.parents[1] / "helpers", HERE.parent / "toys")


def written(which: str, folder: Path, checks: str) -> dict[str, Any]:
    """What `plans.py` writes, by a process whose kernels check indices or do not."""
    file = folder / f"{which}{checks}.json"
    path = os.pathsep.join([*map(str, PATHS), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-c", f"import plans; plans.write({which!r}, {str(file)!r})"], capture_output=True, text=True,
        timeout=900, env={**os.environ, "PYTHONPATH": path, "NUMBA_BOUNDSCHECK": checks}, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(file.read_text())
    return found


@pytest.mark.slow
@pytest.mark.parametrize(("which", "kinds"), [("doors", 3), ("toys", 1)])
def test_plans_are_the_same_where_every_index_is_checked(which: str, kinds: int, tmp_path: Path) -> None:
    checked, usual = (written(which, tmp_path, checks) for checks in ("1", "0"))
    assert checked.keys() == usual.keys() and len({plan["status"] for plan in usual.values()}) >= kinds
    for name, plan in checked.items():
        other = usual[name]
        assert (plan["status"], plan["iterations"]) == (other["status"], other["iterations"]), name
        for field in ("states", "inputs"):
            np.testing.assert_allclose(plan[field], other[field], rtol=0.0, atol=1e-7, err_msg=name)
