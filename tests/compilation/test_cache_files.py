"""Files of the kernel cache: nothing is unpickled but what was saved, whatever happens to them."""

from __future__ import annotations

import logging
import multiprocessing
import os
import pickle
import resource
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from doorman.compilation import cache_place
from doorman.compilation.cache_files import CheckedFiles, write_atomically

DATA = {"machine code": b"\x7fELF" * 500}


class Bomb:
    """Says in a file that it was unpickled."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def __reduce__(self) -> tuple[object, ...]:
        return Path.touch, (self.file,)


@pytest.fixture(autouse=True)
def nothing_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache_place, "_said", set())


@pytest.fixture
def files(tmp_path: Path) -> CheckedFiles:
    kept = CheckedFiles(tmp_path / "cache" / "folder", "module.function-12.py311", "stamp")
    kept.save("float64", DATA)
    kept.save("int64", {"other": b"code" * 300})
    return kept


def index_and_data(folder: Path) -> tuple[Path, list[Path]]:
    (index,) = folder.rglob("*.nbi")
    return index, sorted(folder.rglob("*.nbc"))


def flip(path: Path, share: float) -> None:
    content = bytearray(path.read_bytes())
    content[int(share * (len(content) - 1))] ^= 1
    path.write_bytes(content)


DAMAGES: dict[str, Callable[[Path], object]] = {
    "emptied": lambda path: path.write_bytes(b""),
    "one byte": lambda path: path.write_bytes(b"\x80"),
    "halved": lambda path: os.truncate(path, path.stat().st_size // 2),
    "last byte lost": lambda path: os.truncate(path, path.stat().st_size - 1),
    "longer": lambda path: path.write_bytes(path.read_bytes() + b"\0"),
    "zeros": lambda path: path.write_bytes(bytes(path.stat().st_size)),
    "first bit": lambda path: flip(path, 0.0),
    "a bit inside": lambda path: flip(path, 0.6),
    "last bit": lambda path: flip(path, 1.0),
    "a pickle": lambda path: path.write_bytes(pickle.dumps(Bomb(path.with_name("executed")))),
    "a directory": lambda path: (path.unlink(), path.mkdir()),
    "a link": lambda path: path.rename(path.with_name("elsewhere")).parent and path.symlink_to("elsewhere"),
    "of anybody": lambda path: path.chmod(0o666),
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
@pytest.mark.parametrize("which", ["index", "data"])
def test_a_damaged_file_counts_as_missing_and_is_written_anew(which, damage, files, tmp_path, caplog):
    index, data = index_and_data(tmp_path)
    for path in [index] if which == "index" else data:
        damage(path)
    assert files.load("float64") is None
    assert files.load("int64") is None
    assert not list(tmp_path.rglob("executed"))
    assert [record.levelno for record in caplog.records] == [logging.WARNING]
    assert "compiled anew" in caplog.text
    if not (index.is_dir() or any(path.is_dir() for path in data)):
        files.save("float64", DATA)
        assert files.load("float64") == DATA


def test_what_was_saved_is_loaded_by_another_process(files, tmp_path, caplog):
    again = CheckedFiles(tmp_path / "cache" / "folder", "module.function-12.py311", "stamp")
    assert again.load("float64") == DATA
    assert again.load("complex128") is None
    assert CheckedFiles(tmp_path / "cache" / "folder", "module.function-12.py311", "edited").load("float64") is None
    assert not caplog.records


def test_exchanged_data_files_are_not_taken_for_each_other(files, tmp_path):
    _, (first, second) = index_and_data(tmp_path)
    one, other = first.read_bytes(), second.read_bytes()
    first.write_bytes(other)
    second.write_bytes(one)
    assert files.load("float64") is None
    assert files.load("int64") is None


def test_what_a_damaged_index_left_is_removed(files, tmp_path):
    index, data = index_and_data(tmp_path)
    index.write_bytes(b"")
    files.save("complex128", DATA)
    assert len(index_and_data(tmp_path)[1]) == 1
    neighbour = CheckedFiles(tmp_path / "cache" / "folder", "module.function-12.py311-abc", "stamp")
    neighbour.save("float64", DATA)
    files.save("float64", {"another": b"one"})
    assert neighbour.load("float64") == DATA


def save_some(folder: Path, worker: int) -> None:
    for number in range(10):
        CheckedFiles(folder, "shared", "stamp").save((worker, number), {"code": bytes([worker, number])})


def test_processes_that_save_at_once_lose_nothing(tmp_path):
    workers = [multiprocessing.get_context("fork").Process(target=save_some, args=(tmp_path, i)) for i in range(4)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(30.0)
    loaded = CheckedFiles(tmp_path, "shared", "stamp")
    for worker in range(4):
        for number in range(10):
            assert loaded.load((worker, number)) == {"code": bytes([worker, number])}
    assert not list(tmp_path.glob("*.tmp"))


def test_a_full_disk_leaves_the_old_file(files, tmp_path):
    path = tmp_path / "file"
    write_atomically(path, b"old")
    limits, handler = resource.getrlimit(resource.RLIMIT_FSIZE), signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, limits[1]))
    try:
        with pytest.raises(OSError, match="too large"):
            write_atomically(path, b"new" * 1000)
        with pytest.raises(OSError, match="too large"):
            files.save("complex128", DATA)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, handler)
    assert path.read_bytes() == b"old"
    assert files.load("float64") == DATA
    assert not list(tmp_path.rglob("*.tmp"))


def test_files_are_this_users_alone_whatever_the_mask(tmp_path):
    mask = os.umask(0)
    try:
        CheckedFiles(tmp_path / "folder", "function", "stamp").save("key", DATA)
    finally:
        os.umask(mask)
    assert {path.stat().st_mode & 0o077 for path in tmp_path.rglob("*")} == {0}
