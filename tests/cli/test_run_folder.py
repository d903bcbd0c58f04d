"""Folders of runs: one run at a time writes to one, and new ones are never shared."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from doorman.cli import run_folder as module
from doorman.cli.run_folder import new_folder, run_folder
from doorman.exceptions import DoormanError


def test_new_folders_of_one_second_differ(tmp_path, monkeypatch):
    class Clock:
        @staticmethod
        def now() -> object:
            return __import__("datetime").datetime(2026, 1, 2, 3, 4, 5)

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(module, "datetime", Clock)
    folders: list[Path] = []
    threads = [threading.Thread(target=lambda: folders.append(new_folder("paper"))) for _ in range(40)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(set(folders)) == 40 and all(folder.is_dir() for folder in folders)
    assert Path("runs/paper-20260102-030405") in folders


def test_a_folder_is_given_to_one_at_a_time(tmp_path):
    (tmp_path / "old.txt").write_text("old")
    (tmp_path / "mine.txt").write_text("mine")
    with run_folder(tmp_path, "paper", ["old.txt"]) as folder:
        assert folder == tmp_path and not (tmp_path / "old.txt").exists()
        with pytest.raises(DoormanError, match="another run") as error, run_folder(tmp_path, "paper", ["mine.txt"]):
            pass
        assert error.value.field == "--out" and str(tmp_path) in str(error.value)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]
    with pytest.raises(BlockingIOError, match="of the body"), run_folder(tmp_path, "paper", []):
        raise BlockingIOError("of the body")
