"""`doorman open`: fly a scenario, write the run's folder, say what happened."""

from __future__ import annotations

import json
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from doorman.cli.command import FLY, command
from doorman.cli.options import FeedPort, Json, Settings, Source, Vehicle, flag, folder, valued
from doorman.exceptions import DoormanError

if TYPE_CHECKING:  # commands import what they run when they run it
    from doorman.feasibility import Report

RUN_FILES = (
    "scenario.toml", "recording.mcap", "summary.json", "replay.html",
    *(f"{name}.{kind}" for name in ("states", "constraints", "swing", "planner_time") for kind in ("png", "pdf")),
)  # fmt: skip
"""What a run's folder holds."""


@command(FLY, "open")
def open_door(
    scenario: Source = "paper",
    settings: Settings = None,
    vehicle: Vehicle = None,
    out: Annotated[Path | None, folder("a new one under runs")] = None,
    duration: Annotated[float | None, valued("SECONDS", "Longest simulated time.", "to the mission's end")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the sensors' noise.")] = 0,
    realtime: Annotated[bool, flag("--realtime", "Fly no faster than real time.")] = False,
    view: Annotated[bool, flag("--view", "Show the flight in a browser while it runs; best with --realtime.")] = False,
    port: Annotated[
        int, valued(None, "Port of the page of --view, on this machine.", "any free port", min=0, max=65535)
    ] = 0,
    force: Annotated[bool, flag("--force", "Fly even a scenario that `doorman check` rejects.")] = False,
    feed: FeedPort = None,
    as_json: Json = False,
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
    from doorman.cli.listeners import fed, live_view
    from doorman.cli.run_folder import run_folder
    from doorman.cli.task import check_links, load_task
    from doorman.cli.terminal.display import flight_progress, print_run
    from doorman.feasibility import check
    from doorman.feasibility.swing.postures import unusual_postures
    from doorman.mission import simulate
    from doorman.model import Model
    from doorman.simulation.plant.engine import engine
    from doorman.summary import verdict
    from doorman.visualization import PicturesMissing, write_pictures
    from doorman.visualization.pictures import picture_process

    if duration is not None and not 0.0 < duration <= 3600.0:
        raise DoormanError("not a duration", field="--duration", given=duration, allowed="up to 3600 s")
    task = load_task(scenario, settings, vehicle)
    engine()  # what is missing is said before anything is checked
    with ExitStack() as claims:
        with flight_progress(duration, shown=not as_json) as on_progress:
            model = Model(task)
            check_links(model, vehicle)
            report = check(model)
            _print_complaints(report, force)
            if not report.possible and not force:
                return _refused(report, as_json)
            if postures := unusual_postures(model):
                typer.echo(f"Proposed postures: {postures}", err=as_json)
            results = claims.enter_context(run_folder(out, task.name, RUN_FILES))
            flown = task.replace(model.proposed) if model.proposed else task
            (results / "scenario.toml").write_text(flown.toml(), encoding="utf-8")
            helper = claims.enter_context(picture_process(model))
            with live_view(model, port if view else None) as viewed, fed(feed, viewed) as listener:
                recording = simulate(
                    model, duration, seed, path=results / "recording.mcap", realtime=realtime, on_progress=on_progress,
                    listener=listener, force=force, report=report,
                )  # fmt: skip
        summary = recording.summary
        (results / "summary.json").write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
        try:
            write_pictures(recording, model, results, helper)
        except PicturesMissing as error:
            typer.echo(f"Warning: {error}", err=True)
    good, sentence = verdict(summary)
    end = recording["mission"]
    if end["message"][-1] == "interrupted":
        good, sentence = False, f"Interrupted after {end.time[-1]:.1f} s. Until then: {sentence}"
    print_run(as_json, summary, sentence, results)
    return 0 if good else 1


def _print_complaints(report: Report, force: bool) -> None:
    from doorman.cli.simulated.check import print_findings

    if report.complaints:
        print_findings(report.complaints, err=True)
        if force and not report.possible:
            typer.echo(f"{report.sentence} It flies anyway (--force).", err=True)


def _refused(report: Report, as_json: bool) -> int:
    """Exit status of a scenario that is not flown."""
    if as_json:
        typer.echo(json.dumps(report.as_dict(), indent=2))
    typer.echo(f"{report.sentence} It does not fly; --force flies it anyway.", err=True)
    return 1
