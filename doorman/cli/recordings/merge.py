"""`doorman merge`: a run's recording and the autopilot's own log in one file, on one clock."""

from __future__ import annotations

import json
import math
from pathlib import Path

import typer

from doorman.cli.recordings.recorded import say_what_is_missing
from doorman.exceptions import DoormanError
from doorman.recording import Recording
from doorman.recording.merging import Alignment, align, read_log, write_merged
from doorman.recording.runs import recording_file

FOLDER = "merged"
"""Beside the run's recording, so that its folder stays that of one run."""


def merge_log(run: Path, log: Path, offset: float | None, out: Path | None, as_json: bool) -> int:
    if offset is not None and not math.isfinite(offset):
        raise DoormanError("not a time", field="--offset", given=offset, allowed="seconds")
    file = recording_file(run)
    target = out or file.parent / FOLDER / file.name
    if target.resolve() == file.resolve():
        raise DoormanError(
            "the run's own recording is not overwritten", field="--out", given=str(target), allowed="another file"
        )
    recording, flown = Recording.load(file), read_log(log)
    say_what_is_missing(recording, err=as_json)
    if flown.damaged:
        lost = ", ".join(f"{count} in {name}" for name, count in flown.damaged.items())
        typer.echo(f"{log} is damaged; messages left out: {lost}.", err=True)
    found = align(recording, flown) if offset is None else Alignment(offset, math.nan, "given")
    counts = write_merged(recording, flown, found, target)
    deviation = found.deviation if math.isfinite(found.deviation) else None
    if as_json:
        clock = {"offset": found.offset, "deviation": deviation, "by": found.by}
        typer.echo(
            json.dumps({"file": str(target), **clock, "topics": counts, "damaged": dict(flown.damaged)}, indent=2)
        )
        return 0
    around = "" if deviation is None else f" ± {1e3 * deviation:.1f} ms"
    typer.echo(f"Clock: run = log {found.offset:+.4f} s{around}, by {found.by}.")
    typer.echo(f"{sum(counts.values())} messages of {len(counts)} topics of {flown.autopilot}: {target}")
    return 0
