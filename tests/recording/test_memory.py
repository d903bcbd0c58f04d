"""Long recordings: rows go to the file and come back from there; only what no file takes stays in memory."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from recorded import assert_same

from doorman.exceptions import RecordingError
from doorman.recording import Recorder, Recording


def test_rows_do_not_pile_up_in_memory(tmp_path: Path) -> None:
    def write(recorder: Recorder, first: int, last: int) -> None:
        for k in range(first, last):
            recorder.write("truth", 0.005 * k, {"state": np.full(40, 0.1 * k), "phase": "open"})

    with Recorder(tmp_path / "run.mcap", {}) as recorder:
        write(recorder, 0, 500)  # libraries and buffers are warm
        tracemalloc.start()
        write(recorder, 500, 2000)
        early, _ = tracemalloc.get_traced_memory()
        write(recorder, 2000, 6000)
        late, _ = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        memory = recorder.recording()
    assert late - early < 600_000, "4000 rows of 40 floats take 1.3 MB as arrays, and more as rows"
    assert len(memory["truth"].time) == 6000 and memory.complete
    assert_same(memory, Recording.load(tmp_path / "run.mcap"))


def test_a_device_keeps_nothing_and_memory_everything() -> None:
    with Recorder(Path("/dev/null"), {}) as recorder:
        for k in range(100):
            recorder.write("topic", 0.05 * k, {"value": float(k)})
        assert recorder.recording()["topic"]["value"].tolist() == list(range(100))
    assert len(recorder.recording()["topic"].time) == 100


def test_two_recorders_do_not_write_to_one_file(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with Recorder(path, {"seed": 1}) as recorder:
        recorder.write("topic", 0.0, {"value": 1.0})
        with pytest.raises(RecordingError, match="another recorder"):
            Recorder(path, {"seed": 2})
        recorder.write("topic", 1.0, {"value": 2.0})
    assert Recording.load(path).header == {"seed": 1}
    with Recorder(path, {"seed": 3}):
        pass  # whoever has ended makes room
    again = Recording.load(path)
    assert again.header == {"seed": 3} and again.topics == () and again.complete


def test_a_recording_shares_the_memory_of_its_recorder() -> None:
    recorder = Recorder(None, {})
    for k in range(3000):
        recorder.write("truth", 0.005 * k, {"state": np.full(40, 0.1 * k)})
    recorder.close()
    first, second = recorder.recording()["truth"]["state"], recorder.recording()["truth"]["state"]
    assert first.shape == (3000, 40) and np.shares_memory(first, second)
    assert not first.flags.writeable
