"""Directory of the kernel cache: nobody else's, and cleared of what old versions left."""

from __future__ import annotations

import os
import stat
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from doorman.compilation import cache_place
from doorman.compilation.cache_place import find_directory

NAME = "doorman-0123456789abcdef"
DAY = 86400.0


@pytest.fixture
def base(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's cache directory, with a temporary directory beside it."""
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "base"))
    monkeypatch.setattr(cache_place, "_said", set())
    return tmp_path / "base"


def link(directory: Path) -> None:
    directory.with_name("elsewhere").mkdir()
    directory.symlink_to("elsewhere")


def opened(mode: int) -> Callable[[Path], None]:
    def make(directory: Path) -> None:
        directory.mkdir()
        directory.chmod(mode)

    return make


TAKEN: dict[str, Callable[[Path], object]] = {
    "a file": lambda directory: directory.write_text("no directory"),
    "a link": link,
    "a link to nothing": lambda directory: directory.symlink_to("nowhere"),
    "open to the group": opened(0o775),
    "open to all": opened(0o777),
    "sticky": opened(0o1777),
}


def private(directory: Path) -> bool:
    found = directory.lstat()
    return stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o077


@pytest.mark.parametrize("take", TAKEN.values(), ids=TAKEN)
def test_a_place_that_others_may_write_is_not_used(take, base, tmp_path, caplog):
    base.mkdir()
    take(base / NAME)
    assert find_directory(NAME) == tmp_path / "temporary" / NAME
    assert private(tmp_path / "temporary" / NAME)
    assert find_directory(NAME) == tmp_path / "temporary" / NAME
    assert len(caplog.records) == 1
    assert str(base / NAME) in caplog.text


@pytest.mark.parametrize("take", [*TAKEN.values(), opened(0o755)], ids=[*TAKEN, "readable to all"])
def test_a_temporary_place_that_others_may_touch_is_not_used_either(take, base, tmp_path, caplog):
    base.write_text("no directory")
    take(tmp_path / "temporary" / NAME)
    found = find_directory(NAME)
    assert found.parent == tmp_path / "temporary"
    assert found.name != NAME
    assert private(found)
    assert len(caplog.records) == 1


def test_a_place_of_another_user_is_not_used(base, tmp_path, monkeypatch):
    for place in (base, tmp_path / "temporary"):
        (place / NAME).mkdir(parents=True, mode=0o700)
    own = os.getuid()
    if own == 0:
        os.chown(base / NAME, 4242, -1)
        os.chown(tmp_path / "temporary" / NAME, 4242, -1)
    else:  # nobody but root can give a directory away: be another user instead
        monkeypatch.setattr(os, "getuid", lambda: own + 1)
    found = find_directory(NAME)
    assert found not in (base / NAME, tmp_path / "temporary" / NAME)
    assert found.lstat().st_uid == own


def test_the_users_own_place_is_used_without_a_word(base, caplog):
    mask = os.umask(0)
    try:
        assert find_directory(NAME) == base / NAME
    finally:
        os.umask(mask)
    assert private(base / NAME)
    assert find_directory(NAME) == base / NAME
    assert not caplog.records


@pytest.mark.parametrize("home", ["", "relative", "/proc/nowhere", None])
def test_there_need_not_be_a_home(home, base, tmp_path, monkeypatch):
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    if home is None:
        monkeypatch.setattr(os, "getuid", lambda: 4243)  # the password database knows no such user
        with pytest.raises(RuntimeError):
            Path.home()
        assert not find_directory(NAME).is_relative_to(Path.cwd())
        return
    monkeypatch.setenv("HOME", home)
    monkeypatch.chdir(tmp_path)
    assert find_directory(NAME) == tmp_path / "temporary" / NAME


def version(base: Path, number: int, age: float) -> Path:
    directory = base / f"doorman-{number:016x}"
    (directory / "ocp").mkdir(parents=True)
    (directory / "ocp" / "kernel.nbc").write_bytes(b"code")
    os.utime(directory, (time.time() - age,) * 2)
    return directory


def test_versions_that_nobody_uses_are_removed(base):
    recent = [version(base, i, 0.1 * DAY) for i in range(8)]
    unused = [version(base, i, 1.5 * DAY) for i in range(8, 10)]
    old = [version(base, i, 8.0 * DAY) for i in range(10, 12)]
    find_directory(NAME)
    assert all((directory / "ocp" / "kernel.nbc").is_file() for directory in recent)
    assert not any(directory.exists() for directory in (*unused, *old))


def test_of_few_versions_those_of_the_last_week_are_kept(base, tmp_path):
    kept = [version(base, i, age * DAY) for i, age in enumerate((0.0, 2.0, 6.0))]
    old = version(base, 3, 8.0 * DAY)
    others = [base / name for name in ("doorman", "doorman-abcdefgh", f"{old.name}-mine", "another")]
    for other in others:
        other.mkdir()
        os.utime(other, (0.0, 0.0))
    (base / f"doorman-{5:016x}").symlink_to(tmp_path)
    find_directory(NAME)
    assert all(directory.is_dir() for directory in (*kept, *others, tmp_path))
    assert not old.exists()


def test_use_keeps_a_version(base):
    mine = version(base, 0x0123456789ABCDEF, 30 * DAY)
    assert mine.name == NAME
    assert find_directory(NAME) == mine
    find_directory("doorman-" + 16 * "f")
    assert mine.is_dir()
