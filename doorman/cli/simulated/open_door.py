"""`doorman open`: fly a scenario, write the run's folder, say what happened."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import typer
from rich.console import Console
from rich.text import Text

from doorman.cli.run_folder import run_folder
from doorman.cli.setup.feeding import fed
from doorman.cli.simulated.check import findings_table
from doorman.cli.simulated.live import live_view
from doorman.cli.task import check_links, load_task
from doorman.cli.terminal.display import TYPICAL, flight_progress, print_run
from doorman.exceptions import DoormanError
from doorman.feasibility import Report, check
from doorman.feasibility.swing.postures import unusual_postures
from doorman.mission import simulate
from doorman.model import Model
from doorman.recording import Recording
from doorman.simulation.plant.engine import engine
from doorman.summary import verdict
from doorman.visualization import PicturesMissing, write_pictures
from doorman.visualization.picture_process import PictureProcess, picture_process

RUN_FILES = (
    "scenario.toml", "recording.mcap", "summary.json", "replay.html",
    *(f"{name}.{kind}" for name in ("states", "constraints", "swing", "planner_time") for kind in ("png", "pdf")),
)  # fmt: skip
"""What a run's folder holds."""

_LONGEST = 3600.0
"""Longest flight [s]."""


def open_door(
    source: str,
    settings: Sequence[str],
    out: Path | None,
    duration: float | None,
    seed: int,
    realtime: bool,
    port: int | None,
    as_json: bool,
    force: bool = False,
    feed: int | None = None,
    vehicle: str | None = None,
) -> int:
    """Check a scenario, fly it in simulation if it is possible, and write the folder of the run."""
    if duration is not None and not 0.0 < duration <= _LONGEST:
        raise DoormanError("not a duration", field="--duration", given=duration, allowed=f"up to {_LONGEST:g} s")
    scenario = load_task(source, settings, vehicle)
    engine()  # what is missing is said before anything is checked
    with ExitStack() as claims:
        with flight_progress(duration or TYPICAL, shown=not as_json) as on_progress:
            model = Model(scenario)
            check_links(model, vehicle)
            report = check(model)
            _print_complaints(report, force)
            if not report.possible and not force:
                return _refused(report, as_json)
            if postures := unusual_postures(model):
                typer.echo(f"Proposed postures: {postures}", err=as_json)
            folder = claims.enter_context(run_folder(out, scenario.name, RUN_FILES))
            flown = scenario.replace(model.proposed) if model.proposed else scenario
            (folder / "scenario.toml").write_text(flown.toml(), encoding="utf-8")
            helper = claims.enter_context(picture_process(model))
            with live_view(model, port) as viewed, fed(feed, viewed) as listener:
                recording = simulate(
                    model, duration, seed, path=folder / "recording.mcap", realtime=realtime, on_progress=on_progress,
                    listener=listener, force=force, report=report,
                )  # fmt: skip
        return _report_run(recording, model, folder, helper, as_json)


def _report_run(recording: Recording, model: Model, folder: Path, helper: PictureProcess | None, as_json: bool) -> int:
    summary = recording.summary
    text = json.dumps(summary, indent=2)
    (folder / "summary.json").write_text(text + "\n", encoding="utf-8")
    try:
        write_pictures(recording, model, folder, helper)
    except PicturesMissing as error:
        typer.echo(f"Warning: {error}", err=True)
    good, sentence = _outcome(recording)
    if as_json:
        typer.echo(text)
        typer.echo(sentence, err=True)
    else:
        print_run(summary, sentence, folder)
    return 0 if good else 1


def _print_complaints(report: Report, force: bool) -> None:
    if not report.complaints:
        return
    console = Console(stderr=True, highlight=False)
    console.print(findings_table(report.complaints))
    if force and not report.possible:
        console.print(Text(f"{report.sentence} It flies anyway (--force)."), soft_wrap=True)


def _refused(report: Report, as_json: bool) -> int:
    """Exit status of a scenario that is not flown."""
    if as_json:
        typer.echo(json.dumps(report.as_dict(), indent=2))
    typer.echo(f"{report.sentence} It does not fly; --force flies it anyway.", err=True)
    return 1


def _outcome(recording: Recording) -> tuple[bool, str]:
    good, sentence = verdict(recording.summary)
    end = recording["mission"]
    if end["message"][-1] != "interrupted":
        return good, sentence
    return False, f"Interrupted after {end.time[-1]:.1f} s. Until then: {sentence}"
