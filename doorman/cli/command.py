"""How a function becomes a command: where its help stands, and with which exit status it ends."""

from __future__ import annotations

import errno
import functools
import os
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import typer

from doorman.cli.terminal.streams import lost_stream
from doorman.exceptions import DoormanError, how_to_install

PREPARE, FLY, LOOK = "Before a flight", "In simulation", "After a flight"
VEHICLE = "On a vehicle, real or emulated"
"""Headings under which the help lists the commands."""
BAD_INPUT = 2
"""Exit status for input or surroundings that cannot be used; what was asked for and did not come true is 1."""
FAULT = 3
"""Exit status for what nobody expected."""
INTERRUPTED = 130
"""Exit status of a question whose answer would be 0 or 1, after Ctrl-C: as a shell counts it."""


_EXTRAS = {
    "mujoco": "sim", "matplotlib": "viz", "meshcat": "viz", "pymavlink": "hardware", "serial": "hardware",
    "dynamixel_sdk": "hardware", "distributed": "campaign", "dask": "campaign", "pyarrow": "campaign",
    "tomlkit": "hardware", "motioncapture": "mocap", "packaging": "hardware",
    "cyclonedds": "ros2", "gymnasium": "gym", "cv2": "tags", "pandas": "pandas",
}  # fmt: skip
"""Extra of the package that brings a module in."""


def command(
    app: typer.Typer, panel: str | None = None, name: str | None = None, interrupted: int = 1
) -> Callable[[Callable[..., int]], Callable[..., int]]:
    """Register a function as a command; what it returns is the exit status. It imports what it runs, so that help is fast."""

    def register(function: Callable[..., int]) -> Callable[..., int]:
        @app.command(name, rich_help_panel=panel)
        @functools.wraps(function)
        def run(**arguments: Any) -> None:
            leave(functools.partial(function, **arguments), interrupted)

        return function

    return register


def leave(command: Callable[[], int], interrupted: int = 1) -> None:
    """Run a command and leave with the status that it returns; what goes wrong is one line, no traceback."""
    try:
        status = _status(command)
    except KeyboardInterrupt:
        with suppress(KeyboardInterrupt):  # a second one
            _complain("interrupted.")
        status = interrupted
    raise typer.Exit(status)


def _status(command: Callable[[], int]) -> int:
    try:
        status = command()
        if lost := lost_stream():
            raise OSError(errno.EPIPE, "cannot be written to any more", lost)
        return status
    except (typer.Exit, typer.BadParameter):
        raise
    except DoormanError as error:
        _complain(f"error: {error}")
    except OSError as error:
        _complain(f"error: {error.filename or lost_stream() or 'stdout or a file'}: {error.strerror or error}")
    except ModuleNotFoundError as error:
        extra = _EXTRAS.get((error.name or "").partition(".")[0])
        advice = "" if extra is None else f"; {how_to_install(extra)}"
        _complain(f"error: {error.name} is not installed{advice}")
    except (EOFError, typer.Abort):
        _complain("error: stdin: a question got no answer")
    except UnicodeError as error:
        _complain(f"error: a text that cannot be read or written: {error}")
    except SystemExit as end:
        if end.code != 1:  # rich's, where a pipe's reader has left
            raise
        _complain(f"error: {lost_stream() or 'stdout'}: its reader has closed it")
    except Exception as error:
        if os.environ.get("DOORMAN_TRACEBACK"):
            raise
        _complain(f"error: {type(error).__name__}: {error} (unexpected: DOORMAN_TRACEBACK=1 prints the traceback)")
        return FAULT
    return BAD_INPUT


def _complain(message: str) -> None:
    with suppress(OSError):  # stderr may be gone, too
        typer.echo(f"doorman: {' '.join(message.split())}", err=True)
