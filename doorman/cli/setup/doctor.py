"""`doorman doctor`: what is missing on this computer, each with the command that mends it."""

from __future__ import annotations

import json
from pathlib import Path

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from doorman.hardware.computer.doctor import Complaint, Host, examine
from doorman.hardware.vehicle_file import VehicleFile
from doorman.hardware.vehicle_file.devices import devices

_COLORS = {Complaint.NONE: "green", Complaint.WORSE: "yellow", Complaint.MISSING: "bold red"}


def examine_computer(folder: Path, as_json: bool, vehicle: str | None = None) -> int:
    host = Host()
    rows = examine(host, folder)
    if vehicle is not None:
        rows += devices(host, VehicleFile.load(vehicle))
    missing = any(row.complaint is Complaint.MISSING for row in rows)
    if as_json:
        typer.echo(json.dumps([{**vars(row), "complaint": row.complaint.value} for row in rows], indent=2))
        return int(missing)
    table = Table("", "", "found", box=None, pad_edge=False)
    for row in rows:
        words = f"{row.found}\n→ {row.command}" if row.command else row.found
        table.add_row(
            Text(row.complaint.value, style=_COLORS[row.complaint]), Text(row.name), Text(words, overflow="fold")
        )
    Console(highlight=False).print(table)
    return int(missing)
