"""The application, and how a function becomes one of its commands: where its help stands, with which status it ends."""

from __future__ import annotations

import errno
import functools
import os
from collections.abc import Callable
from contextlib import suppress
from typing import Annotated, Any

import typer

from doorman.cli.terminal.streams import lost_stream
from doorman.exceptions import DoormanError, how_to_install

PREPARE, FLY, LOOK = "Before a flight", "In simulation", "After a flight"
VEHICLE = "On a vehicle, real or emulated"
"""Headings under which the help lists the commands."""
BAD_INPUT = 2
"""Exit status for input or surroundings that cannot be used; a command that ran and did not reach its end returns 1."""
FAULT = 3
"""Exit status for an unexpected error."""
INTERRUPTED = 130
"""Exit status of a question whose answer would be 0 or 1, after Ctrl-C: as a shell counts it."""


_EXTRAS = {
    "mujoco": "sim", "matplotlib": "viz", "meshcat": "viz", "pymavlink": "hardware", "serial": "hardware",
    "dynamixel_sdk": "hardware", "distributed": "campaign", "dask": "campaign", "pyarrow": "campaign",
    "tomlkit": "hardware", "motioncapture": "mocap", "packaging": "hardware",
    "cyclonedds": "ros2", "gymnasium": "gym", "cv2": "tags", "pandas": "pandas",
}  # fmt: skip
"""Extra of the package that brings a module in."""


_HELP = """
Aerial manipulators that open doors.

A multirotor with an arm opens a door with the arm's tip, without a collision with door, doorframe or itself. A planner (model
predictive control by constrained differential dynamic programming) plans one second ahead. A controller follows the plan.
Vehicle, door and contact are simulated in MuJoCo, or real.

A SCENARIO names the URDFs of vehicle and door, the contact, start and goal, and the options of planner, controller and
simulator. It is the name of a shipped scenario, as `doorman list` shows them, or the path of a TOML file. Every key has a
default, and `--set key=value` overrides it. A RUN is the folder that a flight writes, or its recording.

First steps:

- `doorman warmup`: compile the kernels once, so that the first flight starts without delay.
- `doorman list`: what ships.
- `doorman check paper`: is the task possible?
- `doorman open paper --view --realtime`: check it, fly it and watch; the results go to a new folder under runs.
- `doorman view`: watch the newest run again: play, pause, speed, and a slider for the time.

Then:

- `doorman open push --seed 3 --out push-3`: a tip that can only push.
- `doorman open --set contact.height=0.9`: the same task with a higher contact point.
- `doorman campaign push_campaign --runs 20`: random doors, winds and sensors, and the share of successes.
- `doorman rig paper --fly`: the same mission with emulated autopilot, servos and cameras.

Every command with a result takes `--json`: it prints the result to stdout as one JSON document, and messages to stderr.
`doorman --install-completion` completes commands, options, scenarios and keys in the shell.

Exit status: 0 for success (open: the door is open, without a collision; check: the scenario is possible), 1 for failure or a
rejected scenario, 2 if the input or the environment cannot be used, 3 for an unexpected error (DOORMAN_TRACEBACK=1 prints the
traceback).
"""

app = typer.Typer(help=_HELP, no_args_is_help=True, pretty_exceptions_enable=False, rich_markup_mode="markdown")


def _show_version(wanted: bool) -> None:
    if wanted:
        from doorman import __version__

        typer.echo(f"doorman {__version__}")
        raise typer.Exit


@app.callback()
def _doorman(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    pass  # the help is the application's


def command(
    panel: str | None = None, name: str | None = None, interrupted: int = 1, group: typer.Typer = app
) -> Callable[[Callable[..., int]], Callable[..., int]]:
    """Register a function as a command; what it returns is the exit status. It imports what it runs, so that help is fast."""

    def register(function: Callable[..., int]) -> Callable[..., int]:
        @group.command(name, rich_help_panel=panel)
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
