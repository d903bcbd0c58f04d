"""`doorman export`: a recording as tables."""

from __future__ import annotations

import json
from pathlib import Path

import typer
from rich.console import Console
from rich.table import Table

from doorman.cli.recordings.recorded import loaded_run
from doorman.exceptions import DoormanError
from doorman.recording.export import Format, export
from doorman.recording.files.messages import HEADER


def export_run(run: Path | None, as_csv: bool, as_parquet: bool, out: Path | None, as_json: bool) -> int:
    if as_csv and as_parquet:
        raise DoormanError("one format at a time", field="--csv, --parquet", allowed="one of them")
    form: Format = "parquet" if as_parquet else "csv"
    file, recording = loaded_run(run, as_json)
    files = export(recording, out or file.parent / f"{file.stem}-{form}", form)
    counts = {topic: len(recording[topic].time) for topic in recording}
    if as_json:
        written = {topic: {"file": str(files[topic]), "messages": counts.get(topic, 1)} for topic in files}
        typer.echo(json.dumps({"complete": recording.complete, "topics": written}, indent=2))
        return 0
    table = Table("topic", "messages", "file", box=None, pad_edge=False)
    for topic, path in files.items():
        table.add_row(topic, "" if topic == HEADER else str(counts[topic]), path.name)
    console = Console(highlight=False)
    console.print(table)
    console.print(f"\nTables: {files[HEADER].parent}", soft_wrap=True, markup=False)
    return 0
