"""`simulate`: what it takes as scenario, duration, seed and path, and what it refuses before anything is flown."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import doorman
from doorman.exceptions import DoormanError
from doorman.model import Model
from doorman.recording import Recording


def test_a_name_numpys_numbers_and_a_text_are_taken(tmp_path):
    file = tmp_path / "new" / "folder" / "flight.mcap"
    recording = doorman.simulate("paper", np.float32(0.125), np.uint16(3), path=str(file))
    assert recording.header["seed"] == 3 and type(recording.header["seed"]) is int
    assert recording.header["duration"] == 0.125
    assert recording.summary is not None
    assert Recording.load(file).header == recording.header


@pytest.mark.parametrize(
    ("field", "value"),
    [
        *[("seed", seed) for seed in (1.5, 3.0, np.float64(3.0), "3", True, -1, None, 10**30)],
        *[("duration", time) for time in (0.0, -1.0, float("nan"), float("inf"), "1", True, 1j, np.array([1.0]))],
        *[("path", path) for path in ("", ".", Path("."), 3, b"flight.mcap")],
    ],
)
def test_what_cannot_be_flown_is_refused_by_name(model: Model, field, value):
    with pytest.raises(DoormanError) as caught:
        doorman.simulate(model, **({"duration": 0.1} | {field: value}))
    assert caught.value.field == field and caught.value.allowed


def test_a_folder_is_no_file_to_record_to(model: Model, tmp_path):
    for path in (tmp_path, str(tmp_path), f"{tmp_path}/"):
        with pytest.raises(DoormanError, match="path"):
            doorman.simulate(model, 0.1, path=path)
    (tmp_path / "file").touch()
    with pytest.raises(DoormanError, match="cannot be written"):
        doorman.simulate(model, 0.1, path=tmp_path / "file" / "flight.mcap")
    assert not list(tmp_path.glob("**/*.mcap"))
