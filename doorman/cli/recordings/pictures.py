"""`doorman view`, `plot` and `layout`: pictures of a recorded run, and layouts for programs that draw it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from doorman.cli.command import LOOK, command
from doorman.cli.options import Json, Run, folder, valued


@command(LOOK)
def view(
    run: Run = None,
    output: Annotated[
        Path | None,
        valued(
            "FILE",
            "Write the page to this file and open no browser.",
            "replay.html next to the recording",
            "--out",
            "--output",
        ),
    ] = None,
    as_json: Json = False,
) -> int:
    """Show a recorded run in the browser: play, pause, speed, and a slider for the time.

    The page shows vehicle, arm and rotors, door and frame, the tip's trace and force, the plan as a ribbon, and the surfaces
    of the constraints. Their colour shows the clearance: blue for much, orange for little, red for none. The page is one file
    that needs no server and no network.
    """
    from doorman.cli.recordings.recorded import loaded_run, recorded_model
    from doorman.cli.terminal.display import print_result, show_in_browser
    from doorman.visualization.replay import replay_page

    file, recording = loaded_run(run, as_json)
    page = replay_page(recording, recorded_model(recording, file), output or file.parent / "replay.html")
    shown = output is None and show_in_browser(page.resolve().as_uri())
    words = f"{page}{'' if shown or output else ' (open it in a browser)'}"
    print_result(as_json, {"complete": recording.complete, "file": str(page), "opened": shown}, [words])
    return 0


@command(LOOK)
def plot(run: Run = None, out: Annotated[Path | None, folder("the recording's")] = None, as_json: Json = False) -> int:
    """Draw the figures of a recorded run again.

    The command writes the figures of `doorman open`: plots of the states, of constraints and forces, of the swing from above
    and of the planning time (states, constraints, swing, planner_time; each .png and .pdf), and the page that replays the
    motion (replay.html).
    """
    from doorman.cli.recordings.recorded import loaded_run, recorded_model
    from doorman.cli.terminal.display import print_result
    from doorman.visualization import write_pictures

    file, recording = loaded_run(run, as_json)
    files = list(map(str, write_pictures(recording, recorded_model(recording, file), out or file.parent)))
    print_result(as_json, {"complete": recording.complete, "files": files}, files)
    return 0


@command(LOOK)
def layout(
    viewer: Annotated[Literal["foxglove", "plotjuggler"], typer.Argument(help="Program that shows recordings.")],
) -> int:
    """Print a layout for a program that shows MCAP recordings: doorman layout foxglove > doorman.json.

    Its panels show the door's angle, the vehicle's position and attitude, the tip's force, the commands, and the planning
    time.
    """
    from doorman.recording import layouts

    typer.echo(layouts.foxglove() if viewer == "foxglove" else layouts.plotjuggler(), nl=False)
    return 0
