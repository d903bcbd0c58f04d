"""Pictures of a run under a name that is mathematics, and with a backend that does not exist."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from doorman.recording import Recording
from doorman.visualization import states_figure

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", ["a $x^ b$", "$\\frac$ α"])
def test_names_are_no_mathematics(fly, model, tmp_path, name):
    recording = fly(model, 0.1)
    figure = states_figure(Recording(dict(recording), {"name": name}), model)
    figure.savefig(tmp_path / "states.png", dpi=20)


def test_a_backend_that_does_not_exist_is_not_needed():
    code = """
import os, doorman.visualization.style as style
style.Figure()
import matplotlib
assert os.environ["MPLBACKEND"] == "nonsense" != matplotlib.rcParams["backend"]
"""
    subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": "nonsense"}, check=True,
        timeout=120,
    )  # fmt: skip
