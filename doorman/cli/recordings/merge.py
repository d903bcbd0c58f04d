"""`doorman merge`: a run's recording and the autopilot's own log in one file, on one clock."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from doorman.cli.command import LOOK, command
from doorman.cli.options import Json, valued
from doorman.exceptions import DoormanError

FOLDER = "merged"
"""Beside the run's recording, so that its folder stays that of one run."""


@command(LOOK)
def merge(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run's folder, or an MCAP file.")],
    log: Annotated[Path, typer.Argument(metavar="LOG", help="PX4 ULog (.ulg), or ArduPilot DataFlash log (.bin).")],
    offset: Annotated[float | None, valued("SECONDS", "Run's clock minus the log's.", "found automatically")] = None,
    out: Annotated[Path | None, valued("FILE", "File to write.", "in the folder merged next to the recording")] = None,
    as_json: Json = False,
) -> int:
    """Merge the autopilot's own log and a run's recording into one MCAP file with one clock.

    TIMESYNC aligns the clocks if the run or the log contains it, otherwise the cross-correlation of the body rates. The
    command prints the offset and its standard deviation. The log's topics are named px4/… or ardupilot/…, in the log's own
    units and axes. The file omits messages from before the run. The command does not change the recording.
    """
    from doorman.cli.recordings.recorded import say_what_is_missing
    from doorman.cli.terminal.display import print_result
    from doorman.recording import Recording
    from doorman.recording.merging import Alignment, align, read_log, write_merged
    from doorman.recording.runs import recording_file

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
    around = "" if deviation is None else f" ± {1e3 * deviation:.1f} ms"
    clock = {"offset": found.offset, "deviation": deviation, "by": found.by}
    print_result(
        as_json, {"file": str(target), **clock, "topics": counts, "damaged": dict(flown.damaged)},
        [f"Clock: run = log {found.offset:+.4f} s{around}, by {found.by}.",
         f"{sum(counts.values())} messages of {len(counts)} topics of {flown.autopilot}: {target}"],
    )  # fmt: skip
    return 0
