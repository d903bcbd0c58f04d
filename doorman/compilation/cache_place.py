"""Where the cache of compiled kernels is: a directory that no other user may write, cleared of what old versions left.

Kernels are native code, so whoever writes the cache runs what they like. A directory is used only if it belongs to this user
and no other user may write it.
"""

from __future__ import annotations

import atexit
import logging
import os
import re
import shutil
import stat
import tempfile
import time
from pathlib import Path

_VERSION = re.compile(r"doorman-[0-9a-f]{16}")
"""Name of the directory of one version."""

_DAY = 86400.0
_LONGEST_UNUSED = 7.0 * _DAY
"""Time without use after which a version is removed [s]."""

_KEPT = 4
"""So many versions are kept for that time; one beyond them is removed after a day without use."""

_said: set[str] = set()


def say_once(kind: str, message: str) -> None:
    """Log a warning, the first time that one of its kind comes up in this process."""
    if kind not in _said:
        _said.add(kind)
        logging.getLogger("doorman").warning("doorman: %s", message)


def find_directory(name: str) -> Path:
    """Directory of this version: under the user's cache, else under the temporary one, else a fresh one for this process."""
    refusals: list[str] = []
    for base, foreign_bits in ((_users_base(), 0o022), (Path(tempfile.gettempdir()), 0o077)):
        reason = "no home directory" if base is None else _refusal(base / name, foreign_bits)
        if base is not None and reason is None:
            if refusals:
                say_once("place", f"compiled kernels are kept in {base / name}, because {'; '.join(refusals)}")
            touch(base / name)
            _remove_old(base / name)
            return base / name
        refusals.append(str(reason))
    say_once("place", f"compiled kernels are kept for this process only, because {'; '.join(refusals)}")
    return fresh_directory()


def fresh_directory() -> Path:
    """A private directory that is removed when this process ends."""
    fresh = Path(tempfile.mkdtemp(prefix="doorman-"))
    atexit.register(_remove_own, fresh, os.getpid())
    return fresh


def touch(directory: Path) -> None:
    """Note that a version is in use, by the time of its directory."""
    try:
        os.utime(directory)
    except OSError:
        pass  # it looks unused, and is compiled anew if another version removes it


def _users_base() -> Path | None:
    given = os.environ.get("NUMBA_CACHE_DIR")
    if given:
        return Path(given).absolute()
    place = os.environ.get("XDG_CACHE_HOME", "")
    if os.path.isabs(place):
        return Path(place)
    home = os.environ.get("HOME", os.path.expanduser("~"))  # without HOME that of the password database, or "~"
    return Path(home) / ".cache" if os.path.isabs(home) else None


def _refusal(directory: Path, foreign_bits: int) -> str | None:
    """Why a directory cannot be used; made if it does not exist."""
    try:
        directory.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = directory.lstat()
    except OSError as error:
        return f"{directory} cannot be made ({error.strerror})"
    if not stat.S_ISDIR(found.st_mode):
        return f"{directory} is no directory"
    if found.st_uid != os.getuid():
        return f"{directory} belongs to another user"
    if found.st_mode & foreign_bits:
        return f"{directory} is open to other users (mode {stat.S_IMODE(found.st_mode):o})"
    return None if os.access(directory, os.W_OK | os.X_OK) else f"{directory} cannot be written"


def _remove_old(used: Path) -> None:
    """Remove the directories of versions that are not used any more, beside one that is."""
    ages, now = {}, time.time()
    try:
        for entry in os.scandir(used.parent):
            if _VERSION.fullmatch(entry.name) and entry.name != used.name and entry.is_dir(follow_symlinks=False):
                found = entry.stat(follow_symlinks=False)
                if found.st_uid == os.getuid():
                    ages[entry.path] = now - found.st_mtime
    except OSError:
        return  # a parent that may not be listed, or an entry that another process has just removed
    for rank, path in enumerate(sorted(ages, key=lambda path: ages[path]), start=2):
        if ages[path] > (_DAY if rank > _KEPT else _LONGEST_UNUSED):
            shutil.rmtree(path, ignore_errors=True)


def _remove_own(directory: Path, process: int) -> None:
    if os.getpid() == process:  # a fork of it may still load from there
        shutil.rmtree(directory, ignore_errors=True)
