"""`doorman doctor` and `doorman system`: what is missing on this computer, and files for its system."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Literal

import typer

from doorman.cli.command import VEHICLE, command
from doorman.cli.options import Json, Vehicle, valued


@command(VEHICLE)
def system(file: Annotated[Literal["udev", "limits", "service"], typer.Argument(help="Which file.")]) -> int:
    """Print a file for the vehicle's Linux: udev rules for servo adapter and Pixhawk, limits, or a systemd unit.

    The first line of the file says where to put it: doorman system udev | sudo tee /etc/udev/rules.d/99-doorman.rules
    """
    from doorman.hardware.computer.doctor import SYSTEM_FILES

    typer.echo(SYSTEM_FILES[file].text, nl=False)
    return 0


@command(VEHICLE)
def doctor(
    runs: Annotated[Path, valued("DIR", "Folder of recordings.", "runs")] = Path("runs"),
    vehicle: Vehicle = None,
    as_json: Json = False,
) -> int:
    """Check whether this computer is ready to fly, and print the command that fixes each problem.

    The command checks versions, permissions of serial devices, latency timers, ModemManager, real-time priority, governor,
    clock, network buffers, disk and compiled kernels. With --vehicle it also checks the devices of this file. It changes
    nothing. The exit status is 1 if a row is marked no.
    """
    from rich.text import Text

    from doorman.cli.terminal.display import COLORS, print_table, with_advice
    from doorman.hardware.computer.doctor import Complaint, Host, examine
    from doorman.hardware.vehicle_file import VehicleFile
    from doorman.hardware.vehicle_file.file import devices

    host = Host()
    rows = examine(host, runs) + ([] if vehicle is None else devices(host, VehicleFile.load(vehicle)))
    if as_json:
        typer.echo(json.dumps([{**vars(row), "complaint": row.complaint.value} for row in rows], indent=2))
    else:
        colors = dict(zip((Complaint.NONE, Complaint.WORSE, Complaint.MISSING), COLORS, strict=True))
        print_table(("", "", "found"), (
            (Text(row.complaint.value, style=colors[row.complaint]), row.name, with_advice(row.found, row.command))
            for row in rows
        ))  # fmt: skip
    return int(any(row.complaint is Complaint.MISSING for row in rows))
