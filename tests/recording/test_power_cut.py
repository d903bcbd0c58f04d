"""A power cut: only what the disk was made to take survives. What that was, is seen at the system's own call."""

from __future__ import annotations

import os
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from doorman.exceptions import RecordingError
from doorman.recording import Recorder, Recording


class Disk:
    """Holds of every file what it held when fsync was last called; a folder's names count by its own fsync."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.files: dict[int, bytes] = {}
        self.folders: set[str] = set()
        self._fsync = os.fsync
        monkeypatch.setattr(os, "fsync", self._take)

    def _take(self, descriptor: int) -> None:
        path = Path(os.readlink(f"/proc/self/fd/{descriptor}"))
        if path.is_dir():
            self.folders.add(str(path))
        else:
            self.files[os.fstat(descriptor).st_ino] = path.read_bytes()
        self._fsync(descriptor)

    def survives(self, path: Path, folder: Path) -> Recording:
        """The recording as the disk has it after the cut."""
        assert str(path.parent) in self.folders
        left = folder / "left.mcap"
        left.write_bytes(self.files[path.stat().st_ino])
        return Recording.load(left)


def rows(recording: Recording) -> int:
    return len(recording["topic"].time) if "topic" in recording else 0


def test_a_power_cut_costs_little_more_than_a_tenth_of_a_second(tmp_path, monkeypatch):
    disk = Disk(monkeypatch)
    path = tmp_path / "run" / "flight.mcap"
    with Recorder(path, {"seed": 1}) as recorder:
        lost = []
        for k in range(60):  # in real time, as a vehicle flies
            recorder.write("topic", 0.02 * k, {"state": np.full(9, k / 3)})
            time.sleep(0.02)
            if k % 10 == 9:
                lost.append(0.02 * (k + 1 - rows(disk.survives(path, tmp_path))))
        recorder.close()
    assert np.median(lost) <= 0.2 and max(lost) <= 0.5  # a tenth for the batch; the rest for a busy machine
    end = disk.survives(path, tmp_path)
    assert end.complete and rows(end) == 60  # what was closed is there
    assert end.header == {"seed": 1}


def test_a_disk_that_takes_nothing_more_is_told_and_memory_keeps_the_rest(tmp_path, monkeypatch):
    def broken(descriptor: int) -> Any:
        raise OSError(5, "Input/output error")

    recorder = Recorder(tmp_path / "run.mcap", {})
    monkeypatch.setattr(os, "fsync", broken)
    for k in range(100):
        recorder.write("topic", 0.05 * k, {"state": np.full(9, k / 3)})
    with pytest.raises(RecordingError, match="Input/output error"):
        recorder.close()
    recording = recorder.recording()
    assert not recording.complete
    np.testing.assert_array_equal(recording["topic"]["state"][:, 0], np.arange(100) / 3)


def test_a_disk_that_failed_once_is_told_though_it_works_again(tmp_path, monkeypatch):
    """What the system did not write then, it does not write later: a second fsync says nothing of it."""
    failed = threading.Event()

    def broken_once(descriptor: int) -> None:
        if not failed.is_set():
            failed.set()
            raise OSError(5, "Input/output error")

    recorder = Recorder(tmp_path / "run.mcap", {})
    monkeypatch.setattr(os, "fsync", broken_once)
    for k in range(50):
        recorder.write("topic", 0.1 * k, {"value": float(k)})
    assert failed.wait(60.0)
    recorder._syncer._thread.join(60.0)
    recorder.write("topic", 6.0, {"value": 0.0})
    size = recorder.path.stat().st_size
    for k in range(50):
        recorder.write("topic", 6.1 + 0.1 * k, {"value": float(k)})
    assert recorder.path.stat().st_size == size, "such a disk is not written on"
    with pytest.raises(RecordingError, match="Input/output error"):
        recorder.close()


def test_a_slow_disk_does_not_hold_up_whoever_writes(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "fsync", lambda descriptor: time.sleep(0.3))
    recorder = Recorder(tmp_path / "run.mcap", {})
    slowest = 0.0
    for k in range(50):
        began = time.perf_counter()
        recorder.write("topic", 0.1 * k, {"value": float(k)})
        slowest = max(slowest, time.perf_counter() - began)
    monkeypatch.undo()
    recorder.close()
    assert slowest < 0.2
