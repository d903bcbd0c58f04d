"""Export: a recording as one table a topic, as CSV or Parquet, for programs that do not read MCAP."""

from __future__ import annotations

import csv
import importlib
import json
import re
from functools import partial
from pathlib import Path
from typing import Any, Literal, TextIO

from numpy.typing import NDArray

from doorman.exceptions import DoormanError, RecordingError, how_to_install
from doorman.recording.files.cdr import TIME
from doorman.recording.files.header import HEADER
from doorman.recording.recording import Recording, Topic, columns

Format = Literal["csv", "parquet"]

_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n", "＝", "＋", "－", "＠")
"""With one of these a text begins that spreadsheets take for a formula."""
_NUMBER = re.compile(r"-(\d+\.?\d*|\.\d+)(e[+-]?\d+)?|-inf|-nan", re.IGNORECASE)
_UNSAFE = re.compile(r"[^\w-]")
"""What of a topic's name does not go into that of a file."""


def export(recording: Recording, folder: str | Path, form: Format) -> dict[str, Path]:
    """Write one file a topic, and the header as JSON; a text that a spreadsheet would take for a formula is quoted in CSV."""
    if form not in ("csv", "parquet"):
        raise DoormanError("no such format", field="form", given=form, allowed="csv, parquet")
    write = _write_csv if form == "csv" else partial(_write_parquet, _pyarrow())
    folder = Path(folder)
    files = {topic: folder / f"{_UNSAFE.sub('_', topic)}.{form}" for topic in recording}
    if len({str(file).casefold() for file in files.values()}) < len(files):
        raise RecordingError("two topics would be written to the same file", field="topic", given=", ".join(files))
    folder.mkdir(parents=True, exist_ok=True)
    header = folder / f"{HEADER}.json"
    header.write_text(json.dumps(recording.header, indent=2) + "\n", encoding="utf-8")
    for topic, file in files.items():
        write(recording[topic], file)
    return {HEADER: header, **files}


def _write_csv(topic: Topic, file: Path) -> None:
    table = columns({TIME: topic.time, **topic})
    with file.open("w", newline="", encoding="utf-8") as stream:
        rows = csv.writer(_Rows(stream))
        rows.writerow(map(_defused, table))
        rows.writerows(zip(*map(_cells, table.values()), strict=True))


class _Rows:
    """Ends rows by a line feed, and has a text with either character of a line's end quoted."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, row: str) -> None:
        self._stream.write(row.removesuffix("\r\n") + "\n")


def _cells(column: NDArray[Any]) -> list[Any]:
    cells: list[Any] = column.tolist()
    return [_defused(cell) for cell in cells] if column.dtype.kind == "U" else cells


def _defused(text: str) -> str:
    """A text that no spreadsheet takes for a formula."""
    return f"'{text}" if text.startswith(_FORMULA) and not _NUMBER.fullmatch(text) else text


def _pyarrow() -> Any:
    try:
        return importlib.import_module("pyarrow"), importlib.import_module("pyarrow.parquet")
    except ModuleNotFoundError as error:
        raise DoormanError(
            f"Parquet needs pyarrow, which is not installed; {how_to_install('campaign')}",
            field="form", given="parquet", allowed="csv without it",
        ) from error  # fmt: skip


def _write_parquet(modules: Any, topic: Topic, file: Path) -> None:
    pyarrow, parquet = modules
    table = {}
    for name, values in {TIME: topic.time, **topic}.items():
        table[name] = pyarrow.array(values.reshape(-1))
        for size in reversed(values.shape[1:]):
            table[name] = pyarrow.FixedSizeListArray.from_arrays(table[name], size)
    parquet.write_table(pyarrow.table(table), file)
