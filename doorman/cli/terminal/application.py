"""The application that commands are registered with, and its help."""

from __future__ import annotations

from typing import Annotated

import typer

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
