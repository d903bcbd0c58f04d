"""Files of one kernel's cache: read only with the right checksum, and written so that no crash leaves half a file.

The index begins with the checksum of its rest. It names every data file by the checksum of its content, so that a data file
that was emptied, cut, altered or exchanged is not that of the index. numba's own files are pickles without any: whatever is in
them is executed.
"""

from __future__ import annotations

import fcntl
import glob
import hashlib
import os
import pickle
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from numba.core.caching import IndexDataCacheFile

from doorman.compilation.cache_place import say_once, touch

_LOCK_TIME = 5.0
"""Longest wait for another process that writes [s]; without the lock, what one of the two has compiled may be forgotten."""

_TOUCH_INTERVAL = 3600.0
"""Time between two notes that the cache is in use [s]."""

_touched: dict[Path, float] = {}


class CheckedFiles(IndexDataCacheFile):
    """Index and data of the compiled versions of one function.

    Args:
        cache_path: Their directory.
        filename_base: What their names begin with.
        source_stamp: Of the function's source; other sources' kernels are not loaded.
    """

    def __init__(self, cache_path: Path, filename_base: str, source_stamp: Any) -> None:
        super().__init__(str(cache_path), filename_base, source_stamp)  # type: ignore[no-untyped-call]
        self._directory, self._base = cache_path, filename_base
        self._index = cache_path / f"{filename_base}.nbi"

    def load(self, key: Any) -> Any:
        """Load the version that was saved with a key."""
        name = self._load_index().get(key)
        content = None if name is None else _read(self._directory / name)
        if content is None:
            return None
        if self._data_name(content) != name:
            _damaged(self._directory / str(name))
            return None
        _note_use(self._directory.parent)
        return _unpickled(content, self._directory / str(name))

    def save(self, key: Any, data: Any) -> None:
        """Save a compiled version."""
        content = self._dump(data)  # type: ignore[no-untyped-call]
        name = self._data_name(content)
        self._directory.mkdir(mode=0o700, parents=True, exist_ok=True)
        with _locked(self._directory):
            names = {**self._load_index(), key: name}
            write_atomically(self._directory / name, content)
            self._save_index(names)
            self._remove_all_but({self._index.name, *names.values()})

    def _data_name(self, content: bytes) -> str:
        return f"{self._base}.{_checksum(content)[:32].decode()}.nbc"

    def _load_index(self) -> dict[Any, str]:
        content = _read(self._index)
        if content is None:
            return {}
        if _checksum(content[64:]) != content[:64]:
            _damaged(self._index)
            return {}
        stamp, names = _unpickled(content[64:], self._index) or (None, {})
        return dict(names) if stamp == self._source_stamp else {}

    def _save_index(self, names: dict[Any, str]) -> None:
        rest = self._dump((self._source_stamp, names))  # type: ignore[no-untyped-call]
        write_atomically(self._index, _checksum(rest) + rest)

    def _remove_all_but(self, names: set[str]) -> None:
        """Remove what a damaged index, other sources or a killed process left."""
        for path in self._directory.glob(f"{glob.escape(self._base)}.*"):
            if path.name not in names:
                path.unlink(missing_ok=True)


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file as a whole or not at all, whoever else writes it, and whenever power fails."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    descriptor, unfinished = tempfile.mkstemp(prefix=f"{path.stem}.", suffix=".tmp", dir=path.parent)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(unfinished, path)
    except BaseException:
        Path(unfinished).unlink(missing_ok=True)
        raise
    _sync(path.parent)


def _sync(directory: Path) -> None:
    descriptor = os.open(directory, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    except OSError:
        pass  # file systems that do not sync directories
    finally:
        os.close(descriptor)


def _read(path: Path) -> bytes | None:
    """Content of a file of this user's that no other may write; None if there is none."""
    try:
        with open(os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK), "rb") as file:
            found = os.fstat(file.fileno())
            if found.st_uid == os.getuid() and not found.st_mode & 0o022:
                return file.read()
        _damaged(path, "another user may have written it")
    except FileNotFoundError:
        pass
    except OSError as error:
        _damaged(path, str(error.strerror))
    return None


def _unpickled(content: bytes, path: Path) -> Any:
    """What checked bytes hold; None if this version cannot read it."""
    try:
        return pickle.loads(content)
    except Exception:  # names of modules and classes that have changed: any error may come of it
        _damaged(path, "it is of another version")
        return None


def _damaged(path: Path, why: str = "its checksum is wrong") -> None:
    say_once("damage", f"the cache of compiled kernels is damaged; kernels are compiled anew ({path}: {why})")


def _checksum(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()


def _note_use(directory: Path) -> None:
    now = time.monotonic()
    if now > _touched.get(directory, now) + _TOUCH_INTERVAL:
        touch(directory)
        _touched[directory] = now
    _touched.setdefault(directory, now)


@contextmanager
def _locked(directory: Path) -> Iterator[None]:
    """Keep other processes from writing to a directory."""
    descriptor = os.open(directory, os.O_RDONLY | os.O_DIRECTORY)
    try:
        end = time.monotonic() + _LOCK_TIME
        while time.monotonic() < end:
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                time.sleep(0.01)
            except OSError:
                break  # a file system without locks
        yield
    finally:
        os.close(descriptor)
