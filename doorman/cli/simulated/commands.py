"""`doorman check`, `warmup`, `open` and `campaign`: their arguments and their help."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from doorman.cli.arguments import FeedPort, Settings, Source, Sources, Vehicle
from doorman.cli.command import FLY, INTERRUPTED, PREPARE, command
from doorman.cli.terminal.application import app


@command(app, PREPARE, "check", interrupted=INTERRUPTED)
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
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="Also print what is fine, with its numbers and limits.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the findings as JSON.")] = False,
) -> int:
    """Check whether a scenario can work, before any flight.

    The command checks masses and inertias, and loads the URDFs in MuJoCo if it is installed. It checks the arm's reach and joint
    limits, the rotor disc between the jambs along the whole swing, thrust and tilt for the force that the door needs, start and
    goal against the constraints, and the path from the hover to the leaf. A short rehearsal shows whether the planner opens the
    door. If nothing speaks against it, the command flies the scenario once in simulation: what is possible has been flown. The
    command prints warnings and errors, each with the number, its limit and what to change. `-v` also prints what is fine.

    `doorman open`, `doorman fly` and `doorman.simulate` decide by the same findings. The exit status is 0 if the scenario is
    possible, 1 if it is not.
    """
    from doorman.cli.simulated.check import check_scenario

    return check_scenario(scenario, settings or [], as_json, audit, vehicle, quick, verbose)


@command(app, PREPARE, "list")
def list_command(
    as_json: Annotated[bool, typer.Option("--json", help="Print the list as JSON.")] = False,
) -> int:
    """List the scenarios that ship, in words.

    Each name is a SCENARIO of `doorman check`, `doorman open` and the other commands. The gallery in the documentation shows a
    flight of each.
    """
    from doorman.cli.simulated.listing import list_scenarios

    return list_scenarios(as_json)


@command(app, PREPARE, "warmup")
def warmup_command(
    scenarios: Sources = None,
    settings: Settings = None,
    vehicle: Vehicle = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON; no progress bar.")] = False,
) -> int:
    """Compile all kernels in advance, so that planner, check and flight start without delay.

    The command compiles the kernels of planner, dynamics, constraints, controller and simulator, for the number of joints of the
    scenarios' arms. A cache on disk keeps them until doorman, Numba or Python changes. An arm with another number of joints needs
    another warm-up.

    The last line shows the number of compiled kernels, the time, and the directory of the cache. The environment variable
    NUMBA_CACHE_DIR changes this directory. doorman removes kernels of other versions after a week without use, and beyond four
    versions after a day.
    """
    from doorman.cli.simulated.warmup import warm_up

    return warm_up(scenarios or [], settings or [], as_json, vehicle)


@command(app, FLY, "open")
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
) -> int:
    """Fly a scenario in simulation, from hover to hover.

    The command first checks the scenario, like `doorman check`, and prints warnings and errors to stderr. It does not fly a
    scenario with errors and writes no folder, unless you give `--force`. With `--json` it then prints the findings to stdout.

    It writes a folder: the recording (recording.mcap), the figures of the run (summary.json), the scenario with all its values
    (scenario.toml), plots of the states, of constraints and forces, of the swing from above and of the planning time (states,
    constraints, swing, planner_time; each .png and .pdf), and a page that replays the motion in a browser (replay.html).

    Ctrl-C ends the flight and keeps its data. The exit status is 0 only if the door is open, without a collision. Otherwise, and
    if the check rejects the scenario, it is 1, and a message says what happened.
    """
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


@command(app, FLY)
def campaign(
    scenario: Source = "push_campaign",
    settings: Settings = None,
    vehicle: Vehicle = None,
    runs: Annotated[
        int | None, typer.Option(min=1, max=1_000_000, help="Number of flights.", show_default="the scenario's")
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(min=1, max=1024, help="Flights at a time on this machine.", show_default="one per core"),
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Fly on an existing Dask cluster: tcp://host:port.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder for the results.", show_default="runs/campaign-SCENARIO"),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the report's figures as JSON; no progress.")] = False,
) -> int:
    """Fly a scenario many times, with random doors, winds and sensors, and report how often it works.

    The scenario's table campaign.vary defines the distributions. The values of run i depend only on campaign.seed and on i.

    The command writes a folder: the report (report.md, report.json, histograms.png), one row per run (results.parquet), and
    one file per run (runs). The same command continues an interrupted campaign where it stopped. A larger number of runs
    continues a finished campaign. The report lists every failure with the command that flies it again.

    The exit status is 0 if all runs were flown, with or without success.
    """
    from doorman.cli.simulated.campaign import fly_campaign

    return fly_campaign(scenario, settings or [], runs, workers, scheduler, out, as_json, vehicle)
