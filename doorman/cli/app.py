"""The `doorman` command: its arguments, its help and its exit status."""

from __future__ import annotations

import errno
import gc
import os
import signal
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from doorman.cli.arguments import FeedPort, Settings, Source, Sources, Vehicle
from doorman.cli.recordings.commands import add_run_commands
from doorman.cli.setup.commands import add_setup_commands
from doorman.cli.simulated.campaign_command import add_campaign_command
from doorman.cli.terminal import panels
from doorman.cli.terminal.streams import lost_stream, steady_streams
from doorman.cli.vehicles.commands import add_vehicle_commands
from doorman.cli.vehicles.door_commands import add_tag_commands
from doorman.cli.vehicles.file_commands import add_vehicle_file_commands
from doorman.exceptions import DoormanError, how_to_install

BAD_INPUT = 2
"""Exit status for input or surroundings that cannot be used; what was asked for and did not come true is 1."""
FAULT = 3
"""Exit status for what nobody expected."""
INTERRUPTED = 130
"""Exit status of a question whose answer would be 0 or 1, after Ctrl-C: as a shell counts it."""

_COLLECTIONS = 50_000, 20, 100
"""Python's thresholds of garbage collection: with its own, imports spend an eighth of their time looking for what is none."""

_EXTRAS = {
    "mujoco": "sim", "matplotlib": "viz", "meshcat": "viz", "pymavlink": "hardware", "serial": "hardware",
    "dynamixel_sdk": "hardware", "distributed": "campaign", "dask": "campaign", "pyarrow": "campaign",
    "tomlkit": "hardware", "motioncapture": "mocap", "packaging": "hardware",
    "cyclonedds": "ros2", "gymnasium": "gym", "cv2": "tags",
}  # fmt: skip
"""Extra of the package that brings a module in."""

_HELP = """
Aerial manipulators that open doors.

A multirotor with an arm opens a door with the arm's tip, without a collision with door, doorframe or itself. A planner (model
predictive control by constrained differential dynamic programming) plans one second ahead. A controller follows the plan.
Vehicle, door and contact are simulated in MuJoCo, or real.

A SCENARIO names the URDFs of vehicle and door, the contact, start and goal, and the options of planner, controller and
simulator. It is the name of a shipped scenario (paper, push, push_campaign) or the path of a TOML file. Every key has a
default, and `--set key=value` overrides it. A RUN is the folder that a flight writes, or its recording.

First steps:

- `doorman warmup`: compile the kernels once, so that the first flight starts without delay.
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


def main() -> None:
    steady_streams()
    gc.set_threshold(*_COLLECTIONS)
    try:
        app(prog_name="doorman")
    finally:  # from here on Ctrl-C ends the process without a word
        signal.signal(signal.SIGINT, signal.SIG_DFL)


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


@app.command("check", rich_help_panel=panels.PREPARE)
def check_command(
    scenario: Source = "paper",
    settings: Settings = None,
    vehicle: Vehicle = None,
    audit: Annotated[
        bool,
        typer.Option("--audit", help="Also search for collisions that the constraints allow; takes some seconds."),
    ] = False,
    quick: Annotated[
        bool, typer.Option("--quick", help="Do not fly it in simulation, which takes some seconds.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the findings as JSON.")] = False,
) -> None:
    """Check whether a scenario can work, before any flight.

    The command checks masses and inertias, and loads the URDFs in MuJoCo if it is installed. It checks the arm's reach and joint
    limits, the rotor disc between the jambs along the whole swing, thrust and tilt for the force that the door needs, start and
    goal against the constraints, and the path from the hover to the leaf. A short rehearsal shows whether the planner opens the
    door. If nothing speaks against it, the command flies the scenario once in simulation: what is possible has been flown. Every
    finding names the number, its limit and what to change.

    `doorman open`, `doorman fly` and `doorman.simulate` decide by the same findings. The exit status is 0 if the scenario is
    possible, 1 if it is not.
    """

    def command() -> int:
        from doorman.cli.simulated.check import check_scenario

        return check_scenario(scenario, settings or [], as_json, audit, vehicle, quick)

    _leave(command, interrupted=INTERRUPTED)


@app.command("warmup", rich_help_panel=panels.PREPARE)
def warmup_command(
    scenarios: Sources = None,
    settings: Settings = None,
    vehicle: Vehicle = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON; no progress bar.")] = False,
) -> None:
    """Compile all kernels in advance, so that planner, check and flight start without delay.

    The command compiles the kernels of planner, dynamics, constraints, controller and simulator, for the number of joints of the
    scenarios' arms. A cache on disk keeps them until doorman, Numba or Python changes. An arm with another number of joints needs
    another warm-up.

    The last line shows the number of compiled kernels, the time, and the directory of the cache. The environment variable
    NUMBA_CACHE_DIR changes this directory. doorman removes kernels of other versions after a week without use, and beyond four
    versions after a day.
    """

    def command() -> int:
        from doorman.cli.simulated.warmup import warm_up

        return warm_up(scenarios or [], settings or [], as_json, vehicle)

    _leave(command)


@app.command("open", rich_help_panel=panels.FLY)
def open_command(
    scenario: Source = "paper",
    settings: Settings = None,
    vehicle: Vehicle = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder for the results.", show_default="a new one under runs"),
    ] = None,
    duration: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", help="Longest simulated time.", show_default="to the mission's end"),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the sensors' noise.")] = 0,
    realtime: Annotated[bool, typer.Option("--realtime", help="Fly no faster than real time.")] = False,
    view: Annotated[
        bool, typer.Option("--view", help="Show the flight in a browser while it runs; best with --realtime.")
    ] = False,
    port: Annotated[
        int,
        typer.Option(
            min=0, max=65535, help="Port of the page of --view, on this machine.", show_default="any free port"
        ),
    ] = 0,
    force: Annotated[bool, typer.Option("--force", help="Fly even a scenario that `doorman check` rejects.")] = False,
    feed: FeedPort = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print only the summary, as JSON; no progress bar, no table.")
    ] = False,
) -> None:
    """Fly a scenario in simulation, from hover to hover.

    The command first checks the scenario, like `doorman check`, and prints warnings and errors to stderr. It does not fly a
    scenario with errors and writes no folder, unless you give `--force`. With `--json` it then prints the findings to stdout.

    It writes a folder: the recording (recording.mcap), the figures of the run (summary.json), the scenario with all its values
    (scenario.toml), plots of the states, of constraints and forces, of the swing from above and of the planning time (states,
    constraints, swing, planner_time; each .png and .pdf), and a page that replays the motion in a browser (replay.html).

    Ctrl-C ends the flight and keeps its data. The exit status is 0 only if the door is open, without a collision. Otherwise, and
    if the check rejects the scenario, it is 1, and a message says what happened.
    """

    def command() -> int:
        from doorman.cli.simulated.open_door import open_door

        return open_door(
            scenario,
            settings or [],
            out,
            duration,
            seed,
            realtime,
            port if view else None,
            as_json,
            force,
            feed,
            vehicle,
        )

    _leave(command)


def _leave(command: Callable[[], int], interrupted: int = 1) -> None:
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


add_campaign_command(app, _leave)
add_run_commands(app, _leave)
add_vehicle_commands(app, _leave)
add_setup_commands(app, _leave)
add_vehicle_file_commands(app, _leave)
add_tag_commands(app, _leave)
