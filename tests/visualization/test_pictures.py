"""Pictures of a run on a disk that fills up, under a name that is mathematics, and with a backend that does not exist."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from doorman.recording import Recording
from doorman.visualization import PicturesMissing, pictures, states_figure, write_pictures
from doorman.visualization.style import Figure

ROOT = Path(__file__).parents[2]


@pytest.fixture
def quick(monkeypatch):
    """Pictures that are drawn at once; what is tried is how they are written."""
    monkeypatch.setattr(pictures, "figure_of", lambda name, recording, model: Figure(figsize=(1, 1)))


def test_a_disk_that_fills_up_costs_the_pictures_that_do_not_fit(quick, flight, model, tmp_path, monkeypatch):
    save_as = pictures.save_as

    def full(figure: Figure, file: Path) -> None:
        if file.name in ("states.pdf", "swing.png"):
            file.write_bytes(b"a part")
            raise OSError(errno.ENOSPC, "No space left on device")
        save_as(figure, file)

    monkeypatch.setattr(pictures, "save_as", full)
    with pytest.raises(PicturesMissing) as error:
        write_pictures(flight, model, tmp_path)
    assert str(error.value) == f"{tmp_path}: missing: states.pdf, swing.png: No space left on device"
    assert {path.name for path in tmp_path.iterdir()} == {
        "states.png", "constraints.png", "constraints.pdf", "swing.pdf", "planner_time.png", "planner_time.pdf", "replay.html",
    }  # fmt: skip


def test_a_file_system_that_is_really_full(quick, flight, model, tmp_path):
    for name in ("constraints.png", "replay.html"):
        (tmp_path / name).symlink_to("/dev/full")
    with pytest.raises(PicturesMissing, match=r"missing: constraints.png, replay.html: No space left"):
        write_pictures(flight, model, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {
        "states.png", "states.pdf", "constraints.pdf", "swing.png", "swing.pdf", "planner_time.png", "planner_time.pdf",
    }  # fmt: skip


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
