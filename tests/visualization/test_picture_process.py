"""A process that draws beside the flight: what it draws is what is drawn here, and where it dies, it is drawn here."""

from __future__ import annotations

import os
import signal
import sys
import time
from pathlib import Path

import pytest

from doorman.mission import simulate
from doorman.model import Model
from doorman.recording import Recording
from doorman.visualization import PicturesMissing, pictures, write_pictures
from doorman.visualization.pictures import PictureProcess, picture_process
from doorman.visualization.style import Figure

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="it is forked on Linux alone")

NAMES = {f"{name}.{suffix}" for name in ("states", "constraints", "swing", "planner_time") for suffix in ("png", "pdf")}


@pytest.fixture
def run(model: Model, tmp_path: Path) -> Recording:
    """A recording in a folder, as `doorman open` has it."""
    return simulate(model, 0.05, path=tmp_path / "recording.mcap", force=True)


@pytest.fixture
def drawn_here(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Figures that are drawn at once, and the names of those that this process draws."""
    here, me = [], os.getpid()

    def draw(name: str, recording: Recording, model: Model) -> Figure:
        assert len(recording["truth"].time) > 1 and model.n_arm
        if os.getpid() == me:
            here.append(name)
        return Figure(figsize=(1, 1))

    monkeypatch.setattr(pictures, "figure_of", draw)
    return here


def test_the_process_draws_everything_but_the_page(run, model, tmp_path, drawn_here):
    helper = PictureProcess(model)
    files = write_pictures(run, model, tmp_path, helper)
    helper.close()
    assert drawn_here == [] and {file.name for file in files} == {*NAMES, "replay.html"}
    assert all(file.stat().st_size > 500 for file in files)


def test_what_a_process_that_dies_has_not_drawn_is_drawn_here(run, model, tmp_path, drawn_here):
    helper = PictureProcess(model)
    os.kill(helper._process.pid, signal.SIGKILL)
    files = write_pictures(run, model, tmp_path, helper)
    helper.close()
    assert drawn_here == list(pictures._FIGURES) and all(file.is_file() for file in files)


@pytest.mark.parametrize("helped", [True, False])
def test_files_that_cannot_be_written_are_told_and_the_others_are_there(run, model, tmp_path, drawn_here, helped):
    full = {"constraints.png", "swing.pdf", "replay.html"}
    for name in full:
        (tmp_path / name).symlink_to("/dev/full")
    helper = PictureProcess(model) if helped else None
    with pytest.raises(PicturesMissing) as error:
        write_pictures(run, model, tmp_path, helper)
    if helper is not None:
        helper.close()
    assert str(error.value) == f"{tmp_path}: missing: constraints.png, swing.pdf, replay.html: No space left on device"
    assert {file.name for file in tmp_path.iterdir()} == {*NAMES, "recording.mcap"} - full, "nor is a part of one"


def test_a_process_without_an_order_goes_and_ctrl_c_is_not_its_own(model):
    with picture_process(model) as helper:
        if helper is None:
            pytest.skip("a single core")
        process = helper._process
        time.sleep(0.1)
        os.kill(process.pid, signal.SIGSTOP)  # whatever it does
    assert not process.is_alive()
