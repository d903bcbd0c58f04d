"""Results: one row a run, each durable in a Parquet file of its own as soon as it is known, merged at the end.

A file holds the SHA-256 of itself, taken with zeros in its place: one flipped bit makes it no row.
"""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pyarrow as arrow
import pyarrow.parquet as parquet

from doorman.bounds import LARGEST_TEXT, read_bytes
from doorman.campaign.judgement import final_error, judge, told_truly
from doorman.campaign.specification import Flight
from doorman.compilation.cache_files import write_atomically
from doorman.exceptions import DoormanError
from doorman.scenario.dotted import leaves

DRAWN, SUMMARY = "drawn.", "summary."
"""What the names of columns begin with."""
OF_THE_CLOCK = (
    "wall_time_s", "kernels_compiled", "summary.realtime_factor", "summary.deadline_misses", "summary.planner_ms.median",
    "summary.planner_ms.p99", "summary.planner_ms.max", "summary.planner_ms.cold",
)  # fmt: skip
"""Columns that depend on the machine; all others are the same whenever and wherever a run is flown."""

_SEAL, _DIGITS = b"doorman-sha256:", 64
"""Before the digest in a file's metadata, and the digest's length."""

Row = dict[str, Any]

_log = logging.getLogger("doorman.campaign")


def row_of(flight: Flight, answer: Mapping[str, Any]) -> Row:
    summary = answer["summary"]
    row: Row = {"run": flight.draw.run, "seed": flight.draw.seed}
    if summary is None:
        row |= {"success": False, "safe": False, "outcome": "error", "reason": answer["error"]}
        row["told_truly"] = None
        row |= {"final_error_deg": None, "final_error_m": None, "torque_error_n_m": None}
    else:
        judgement = judge(summary)
        row |= {
            "success": judgement.success,
            "safe": judgement.safe,
            "outcome": summary["outcome"],
            "reason": judgement.reason,
            "final_error_deg": final_error(summary) if summary["unit"] == "deg" else None,
            "final_error_m": final_error(summary) if summary["unit"] == "m" else None,
            "torque_error_n_m": _torque_error(summary),
            "told_truly": None if judgement.success else told_truly(summary),
        }
    row |= {"error": answer["error"], "command": flight.command}
    row |= {"friction": flight.scenario.simulation.door_friction}
    row |= {name: answer[name] for name in ("wall_time_s", "kernels_compiled")}
    row |= {DRAWN + key: _cell(value) for key, value in flight.draw.values.items()}
    return row | {SUMMARY + key: _cell(value) for key, value in leaves(summary or {})}


def write_part(row: Row, folder: Path) -> None:
    """Make a row durable: after this it survives whatever kills the campaign; half of it is never seen."""
    write_table([row], folder / f"{_stem(row['run'])}.parquet")


def read_parts(folder: Path, removes_damaged: bool = False) -> dict[int, Row]:
    """Rows that are durable, by run; a damaged part is left out, or removed, so that its run is flown again."""
    rows: dict[int, Row] = {}
    for path in sorted(folder.glob("run-*.parquet")):
        row = _read_part(path)
        if row is not None:
            rows[row["run"]] = row
        elif removes_damaged:
            _log.warning("%s is damaged: that run is flown again", path)
            path.unlink()
        else:
            _log.warning("%s is damaged: that run counts as not flown", path)
    return rows


def _read_part(path: Path) -> Row | None:
    """The row of a part; None if the part is not what was written."""
    try:
        content = read_bytes(path, LARGEST_TEXT)
        if content != _sealed(content):
            return None
        (row,) = parquet.read_table(arrow.BufferReader(content)).to_pylist()
    except (DoormanError, OSError, ValueError, arrow.ArrowException):
        return None
    return row if path.stem == _stem(row["run"]) else None


def _stem(run: int) -> str:
    return f"run-{run:07d}"


def _sealed(content: bytes) -> bytes:
    """A Parquet file with its digest, whatever stood in the digest's place."""
    start = content.rindex(_SEAL) + len(_SEAL)
    before, behind = content[:start], content[start + _DIGITS :]
    digest = hashlib.sha256(before + bytes(_DIGITS) + behind).hexdigest()
    return before + digest.encode() + behind


def write_table(rows: Iterable[Row], path: Path) -> None:
    """Write rows as one Parquet file, all of it or nothing."""
    rows = list(rows)
    names = dict.fromkeys(name for row in rows for name in row)
    table = arrow.table({name: _column([row.get(name) for row in rows]) for name in names})
    table = table.replace_schema_metadata({"seal": _SEAL + b"0" * _DIGITS})
    content = arrow.BufferOutputStream()
    parquet.write_table(table, content)
    write_atomically(path, _sealed(content.getvalue().to_pybytes()))


def _torque_error(summary: Mapping[str, Any]) -> float | None:
    """Estimated minus true resistance of the hinge at the end [N m]; None if it was not estimated."""
    torque = summary.get("estimates", {}).get("torque")
    return None if torque is None else float(torque["value"]) - float(torque["true"])


def _column(values: list[Any]) -> arrow.Array:
    """A column; what has no common type is text."""
    try:
        return arrow.array(values)
    except (arrow.ArrowInvalid, arrow.ArrowTypeError):
        return arrow.array([None if value is None else json.dumps(value) for value in values])


def _cell(value: Any) -> Any:
    return json.dumps(value) if isinstance(value, (list, tuple)) else value
