"""`doorman view`, `export`, `plot`, `replay`, `estimate`, `merge` and `layout`: their arguments and their help."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from doorman.cli.command import LOOK, command
from doorman.cli.terminal.application import app

_Run = Annotated[
    Path | None,
    typer.Argument(metavar="[RUN]", help="A run's folder, or an MCAP file.", show_default="the newest run under runs"),
]
_Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]


class Viewer(StrEnum):
    """Programs that doorman has a layout for."""

    FOXGLOVE = "foxglove"
    PLOTJUGGLER = "plotjuggler"


@command(app, LOOK)
def view(
    run: _Run = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "--output",
            metavar="FILE",
            help="Write the page to this file and open no browser.",
            show_default="replay.html next to the recording",
        ),
    ] = None,
    as_json: _Json = False,
) -> int:
    """Show a recorded run in the browser: play, pause, speed, and a slider for the time.

    The page shows vehicle, arm and rotors, door and frame, the tip's trace and force, the plan as a ribbon, and the surfaces
    of the constraints. Their colour shows the clearance: blue for much, orange for little, red for none. The page is one file
    that needs no server and no network.
    """
    from doorman.cli.recordings.view import view_run

    return view_run(run, output, as_json)


@command(app, LOOK)
def export(
    run: _Run = None,
    as_csv: Annotated[bool, typer.Option("--csv", help="Write CSV (the default).")] = False,
    as_parquet: Annotated[bool, typer.Option("--parquet", help="Write Parquet; needs the extra campaign.")] = False,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder for the tables.", show_default="recording-csv next to it"),
    ] = None,
    as_json: _Json = False,
) -> int:
    """Write a recording as tables, one file per topic.

    The first column is the time in seconds. Arrays become one column per entry in CSV, and lists in Parquet. The recording's
    header, with the scenario, goes to header.json.
    """
    from doorman.cli.recordings.export import export_run

    return export_run(run, as_csv, as_parquet, out, as_json)


@command(app, LOOK)
def plot(
    run: _Run = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for the files.", show_default="the recording's")
    ] = None,
    as_json: _Json = False,
) -> int:
    """Draw the figures of a recorded run again.

    The command writes the figures of `doorman open`: plots of the states, of constraints and forces, of the swing from above
    and of the planning time (states, constraints, swing, planner_time; each .png and .pdf), and the page that replays the
    motion (replay.html).
    """
    from doorman.cli.recordings.plot import plot_run

    return plot_run(run, out, as_json)


@command(app, LOOK)
def replay(run: _Run = None, as_json: _Json = False) -> int:
    """Solve every plan of a recorded run again, and compare it with the recorded plan bit by bit.

    The planner of the recorded scenario solves each plan from the recorded state and the recorded estimate of the door. Plans
    with a warm start in flight have one here too. Another processor, or another version of doorman, NumPy or Numba, may round
    differently.

    The exit status is 0 if states, inputs, cost, iterations and status of every plan agree to the bit, 1 if not. The command
    compares states with their recorded 32 bits. It does not compare plans that a time limit cut short in flight, and their
    warm-started successors.
    """
    from doorman.cli.recordings.replay import replay_run

    return replay_run(run, as_json)


@command(app, LOOK)
def estimate(
    run: _Run = None,
    changes: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=NUMBER", help="A number of the filter, such as noise.wind=0.3."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for the picture.", show_default="the recording's")
    ] = None,
    as_json: _Json = False,
) -> int:
    """Replay a recorded run's poses and commands through a filter of vehicle and leaf, and draw what it knows.

    The command prints the log-likelihood and the mean normalised innovation squared (NIS) of the poses. With the truth of a
    simulation it also prints the mean normalised error squared (NEES) of the leaf's angle and rate. The picture shows angle,
    normal force, two deviations of each, truth, and the probability of each hypothesis (estimate.png).

    Missions fly on this filter. `--set` shows what other numbers would have made of the same flight.
    """
    from doorman.cli.recordings.estimate import estimate_run

    return estimate_run(run, changes or [], out, as_json)


@command(app, LOOK)
def merge(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run's folder, or an MCAP file.")],
    log: Annotated[Path, typer.Argument(metavar="LOG", help="PX4 ULog (.ulg), or ArduPilot DataFlash log (.bin).")],
    offset: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", help="Run's clock minus the log's.", show_default="found automatically"),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="File to write.", show_default="in the folder merged next to the recording"),
    ] = None,
    as_json: _Json = False,
) -> int:
    """Merge the autopilot's own log and a run's recording into one MCAP file with one clock.

    TIMESYNC aligns the clocks if the run or the log contains it, otherwise the cross-correlation of the body rates. The
    command prints the offset and its standard deviation. The log's topics are named px4/… or ardupilot/…, in the log's own
    units and axes. The file omits messages from before the run. The command does not change the recording.
    """
    from doorman.cli.recordings.merge import merge_log

    return merge_log(run, log, offset, out, as_json)


@command(app, LOOK)
def layout(viewer: Annotated[Viewer, typer.Argument(help="Program that shows recordings.")]) -> int:
    """Print a layout for a program that shows MCAP recordings: doorman layout foxglove > doorman.json.

    Its panels show the door's angle, the vehicle's position and attitude, the tip's force, the commands, and the planning
    time.
    """
    from doorman.recording import layouts

    typer.echo(layouts.foxglove() if viewer is Viewer.FOXGLOVE else layouts.plotjuggler(), nl=False)
    return 0
