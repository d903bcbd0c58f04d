"""`doorman tags print`, and `doorman vehicle door`: what is stuck on a door, and where that stands."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from doorman.cli.arguments import Settings, Source
from doorman.cli.terminal import panels


def add_tag_commands(app: typer.Typer, leave: Callable[[Callable[[], int]], None]) -> None:
    """Register the group."""
    group = typer.Typer(
        help="Tags to stick on a door: measure the leaf by a camera on the vehicle.", no_args_is_help=True
    )

    def print_(
        scenario: Source = "push",
        settings: Settings = None,
        size: Annotated[float, typer.Option(min=0.02, help="Edge of the black square [m].")] = 0.16,
        paper: Annotated[str, typer.Option(help="a4, a3 or letter.")] = "a4",
        out: Annotated[Path, typer.Option(metavar="FILE", help="PDF to write.")] = Path("tags.pdf"),
    ) -> None:
        """Write a PDF with a tag for the leaf and one for the frame, true to size, and print the table for the vehicle file.

        Each page says where its tag goes. Print without scaling: a line on the page is 100 mm long.
        """

        def command() -> int:
            from doorman.cli.vehicles.tags import write_tags

            return write_tags(scenario, settings or [], size, paper, out)

        leave(command)

    group.command("print")(print_)
    app.add_typer(group, name="tags", rich_help_panel=panels.VEHICLE)


def door_command(leave: Callable[[Callable[[], int]], None]) -> Callable[..., None]:
    """`doorman vehicle door`."""

    def door(
        file: Annotated[Path, typer.Argument(metavar="FILE", help="The vehicle file, with [door_sensor].")],
        task: Annotated[
            Path, typer.Argument(metavar="TASK", help="The task's TOML file; the command keeps its comments.")
        ],
    ) -> None:
        """Measure the door's frame with the vehicle's sensor, and write where it stands into the task.

        The vehicle stands on its pad, disarmed. The command opens all links and sends no setpoints.
        """

        def command() -> int:
            from doorman.cli.vehicles.door_measurement import write_frame

            return write_frame(file, task)

        leave(command)

    return door
