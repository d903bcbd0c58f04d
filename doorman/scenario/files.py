"""Files that a scenario names: those that ship with doorman, and the user's own."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from doorman.bounds import LARGEST_TABLES, parse_toml, read_bytes
from doorman.exceptions import ScenarioError
from doorman.resources import scenario_directory, shipped, urdf_directory, vehicle_directory

SHIPPED = "shipped:"
"""Before a name: the shipped file, whatever own files there are."""


@dataclass(frozen=True)
class Kind:
    """One kind of file that ships with doorman."""

    what: str
    suffix: str
    directory: Callable[[], Path]

    def known(self) -> dict[str, Path]:
        """Path by name of every shipped file."""
        return shipped(self.directory(), self.suffix)


URDF = Kind("URDF", ".urdf", urdf_directory)
SCENARIO = Kind("scenario", ".toml", scenario_directory)
VEHICLE_FILE = Kind("vehicle", ".toml", vehicle_directory)


def read_tables(path: Path) -> dict[str, Any]:
    """Tables of a TOML file."""
    content = read_bytes(path, LARGEST_TABLES, ScenarioError)
    try:
        text = content.decode("utf-8-sig")
    except ValueError as error:
        raise ScenarioError(f"not valid TOML: {error}", file=path, allowed="TOML 1.0 in UTF-8") from error
    return parse_toml(text, ScenarioError, path)


def is_path(text: str) -> bool:
    """Whether a text is the path of an own file: it has a slash or a suffix; a bare name is that of a shipped file."""
    return not text.startswith(SHIPPED) and any(mark in text for mark in {"/", os.sep, "."})


def absolute(text: str, folder: Path) -> str:
    """A path as one that holds in any directory; the name of a shipped file stays."""
    return os.path.realpath(folder / text) if is_path(text) else text


def locate(kind: Kind, text: str, folders: Sequence[Path], file: Path | None = None, field: str | None = None) -> Path:
    """The file that a text means: a path is that of an own file, a bare name that of a shipped one."""
    known = kind.known()
    name = text.removeprefix(SHIPPED)
    try:
        own = _own(kind, text, folders, known)
    except OSError as error:
        raise ScenarioError(
            f"cannot be read: {error.strerror}", file=file, field=field, given=text[:80], allowed=f"a {kind.what}"
        ) from error
    if is_path(text):
        if own is not None:
            return own.resolve()
    elif name in known:
        if own is not None:
            raise ScenarioError(
                f"two {kind.what} files of this name, the shipped one and {own}", file=file, field=field, given=text,
                allowed=f"'{_written(own, folders[0])}' for your own, '{SHIPPED}{name}' for the shipped one",
            )  # fmt: skip
        return known[name]
    close = difflib.get_close_matches(Path(name).stem, known, n=1)
    hint = f"; did you mean '{close[0]}'?" if close else ""
    if own is not None and not is_path(text):
        hint = f"; write '{_written(own, folders[0])}' for your own file"
    raise ScenarioError(
        f"no such {kind.what}{hint}", file=file, field=field, given=text,
        allowed=f"a shipped name ({', '.join(known)}), or the path of a {kind.suffix[1:].upper()} file with its suffix, "
        f"here from {folders[0]}",
    )  # fmt: skip


def _own(kind: Kind, text: str, folders: Sequence[Path], known: dict[str, Path]) -> Path | None:
    """The user's own file: at a path, or one that a bare name may mean."""
    if text.startswith(SHIPPED) or "\0" in text:
        return None
    if is_path(text):
        path = folders[0] / text
        return path if path.is_file() else None
    for folder in folders:
        for path in (folder / text, folder / f"{text}{kind.suffix}"):
            if text and path.is_file() and not (text in known and path.samefile(known[text])):
                return path
    return None


def _written(path: Path, folder: Path) -> str:
    """How to write a path in a folder so that it is taken for one."""
    if not path.is_relative_to(folder):
        return str(path)
    relative = str(path.relative_to(folder))
    return relative if is_path(relative) else f"./{relative}"
