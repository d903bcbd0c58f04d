"""Folder of a run: made or taken over for one process alone."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path

from doorman.locks import alone_in
from doorman.recording.runs import RUNS


@contextmanager
def run_folder(out: Path | None, name: str, files: Iterable[str]) -> Iterator[Path]:
    """A folder for one run, without what an earlier one has left of the same files; other files in it stay."""
    folder = new_folder(name) if out is None else out
    folder.mkdir(parents=True, exist_ok=True)
    with alone_in(folder, "another run writes to this folder"):
        for file in files:
            (folder / file).unlink(missing_ok=True)
        yield folder


def new_folder(name: str) -> Path:
    """Make a new folder under `runs`, named after what is run and the time; no two callers get the same."""
    RUNS.mkdir(parents=True, exist_ok=True)
    first = folder = RUNS / f"{name}-{datetime.now():%Y%m%d-%H%M%S}"
    number = 1
    while True:
        try:
            folder.mkdir()
            return folder
        except FileExistsError:
            number += 1
            folder = first.with_name(f"{first.name}-{number}")
