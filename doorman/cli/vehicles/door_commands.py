"""`doorman tags print`, and `doorman vehicle door`: what is stuck on a door, and where that stands."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from doorman.cli.arguments import Settings, Source
from doorman.cli.command import VEHICLE, command
from doorman.cli.terminal.application import app
from doorman.cli.vehicles.file_commands import group as vehicle

tags = typer.Typer(help="Tags to stick on a door: measure the leaf by a camera on the vehicle.", no_args_is_help=True)
app.add_typer(tags, name="tags", rich_help_panel=VEHICLE)


@command(tags, name="print")
def print_(
    scenario: Source = "push",
    settings: Settings = None,
    size: Annotated[float, typer.Option(min=0.02, help="Edge of the black square [m].")] = 0.16,
    paper: Annotated[str, typer.Option(help="a4, a3 or letter.")] = "a4",
    out: Annotated[Path, typer.Option(metavar="FILE", help="PDF to write.")] = Path("tags.pdf"),
) -> int:
    """Write a PDF with a tag for the leaf and one for the frame, true to size, and print the table for the vehicle file.

    Each page says where its tag goes. Print without scaling: a line on the page is 100 mm long.
    """
    from doorman.cli.vehicles.tags import write_tags

    return write_tags(scenario, settings or [], size, paper, out)


@command(vehicle)
def door(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The vehicle file, with [door_sensor].")],
    task: Annotated[Path, typer.Argument(metavar="TASK", help="The task's TOML file; the command keeps its comments.")],
) -> int:
    """Measure the door's frame with the vehicle's sensor, and write where it stands into the task.

    The vehicle stands on its pad, disarmed. The command opens all links and sends no setpoints.
    """
    from doorman.cli.vehicles.door_measurement import write_frame

    return write_frame(file, task)
