"""`doorman export`: a recording as tables."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from doorman.cli.command import LOOK, command
from doorman.cli.options import Json, Run, flag, folder
from doorman.exceptions import DoormanError


@command(LOOK)
def export(
    run: Run = None,
    as_csv: Annotated[bool, flag("--csv", "Write CSV (the default).")] = False,
    as_parquet: Annotated[bool, flag("--parquet", "Write Parquet; needs the extra campaign.")] = False,
    out: Annotated[Path | None, folder("recording-csv next to it")] = None,
    as_json: Json = False,
) -> int:
    """Write a recording as tables, one file per topic.

    The first column is the time in seconds. Arrays become one column per entry in CSV, and lists in Parquet. The recording's
    header, with the scenario, goes to header.json.
    """
    from doorman.cli.recordings.recorded import loaded_run
    from doorman.cli.terminal.display import print_lines, print_result, print_table
    from doorman.recording.export import Format, export
    from doorman.recording.files.header import HEADER

    if as_csv and as_parquet:
        raise DoormanError("one format at a time", field="--csv, --parquet", allowed="one of them")
    form: Format = "parquet" if as_parquet else "csv"
    file, recording = loaded_run(run, as_json)
    files = export(recording, out or file.parent / f"{file.stem}-{form}", form)
    counts = {topic: len(recording[topic].time) for topic in recording}
    written = {topic: {"file": str(files[topic]), "messages": counts.get(topic, 1)} for topic in files}
    print_result(as_json, {"complete": recording.complete, "topics": written}, [])
    if not as_json:
        print_table(
            ("topic", "messages", "file"),
            ((topic, "" if topic == HEADER else str(counts[topic]), path.name) for topic, path in files.items()),
        )
        print_lines(f"\nTables: {files[HEADER].parent}")
    return 0
