"""`doorman campaign`: many flights whose doors, winds and sensors are drawn by chance, and a report of how they went."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from doorman.cli.command import FLY, command
from doorman.cli.options import Json, Settings, Source, Vehicle, folder, valued
from doorman.exceptions import DoormanError

_Row = dict[str, Any]


@command(FLY)
def campaign(
    scenario: Source = "push_campaign",
    settings: Settings = None,
    vehicle: Vehicle = None,
    runs: Annotated[int | None, valued(None, "Number of flights.", "the scenario's", min=1, max=1_000_000)] = None,
    workers: Annotated[
        int | None, valued(None, "Flights at a time on this machine.", "one per core", min=1, max=1024)
    ] = None,
    scheduler: Annotated[str | None, valued("ADDRESS", "Fly on an existing Dask cluster: tcp://host:port.")] = None,
    out: Annotated[Path | None, folder("runs/campaign-SCENARIO")] = None,
    as_json: Json = False,
) -> int:
    """Fly a scenario many times, with random doors, winds and sensors, and report how often it works.

    The scenario's table campaign.vary defines the distributions. The values of run i depend only on campaign.seed and on i.

    The command writes a folder: the report (report.md, report.json, histograms.png), one row per run (results.parquet), and
    one file per run (runs). The same command continues an interrupted campaign where it stopped. A larger number of runs
    continues a finished campaign. The report lists every failure with the command that flies it again.

    The exit status is 0 if all runs were flown, with or without success.
    """
    from doorman.campaign import Campaign
    from doorman.campaign.report.pages import write_report
    from doorman.campaign.running import durable_rows, run_campaign
    from doorman.cli.task import check_links, vehicle_values
    from doorman.cli.values import parse_overrides
    from doorman.model import Model

    if workers is not None and scheduler is not None:
        raise DoormanError(
            "a cluster has its own workers", field="--workers", given=workers, allowed="not with --scheduler"
        )
    drawn = Campaign(scenario, {**vehicle_values(vehicle), **parse_overrides(settings)}, vehicle)
    varied = drawn.scenario
    if vehicle is not None:
        check_links(Model(varied), vehicle)
    planned = varied.campaign.runs if runs is None else runs
    results = out or Path("runs") / f"campaign-{varied.name}"
    results.mkdir(parents=True, exist_ok=True)
    interrupted = False
    with _progress(planned, shown=not as_json) as on_row:
        try:
            rows = run_campaign(drawn, results, runs, workers, scheduler, on_row)
        except KeyboardInterrupt:
            interrupted, rows = True, durable_rows(results)
    figures = write_report(rows, varied, results, planned)
    if as_json:
        typer.echo((results / "report.json").read_text(encoding="utf-8"), nl=False)
    else:
        _print(figures, results, planned, interrupted)
    return 0 if len(rows) >= planned else 1


@contextmanager
def _progress(runs: int, shown: bool) -> Iterator[Callable[[_Row, int, int], None]]:
    """A progress bar on stderr; failures as lines beside it, also where stderr is not a terminal."""
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.text import Text

    from doorman.cli.terminal.display import on_terminal

    successes = 0
    with Progress(
        TextColumn("{task.completed:.0f} of {task.total:.0f} runs"), BarColumn(), TextColumn("{task.fields[good]}"),
        TimeElapsedColumn(), TimeRemainingColumn(), TextColumn("left"), **on_terminal(shown, refresh_per_second=2),
    ) as progress:  # fmt: skip
        task = progress.add_task("", total=runs, good="starting (the first run compiles)")

        def on_row(row: _Row, known: int, total: int) -> None:
            nonlocal successes
            successes += row["success"]
            if shown and not row["success"]:
                progress.console.print(Text(f"run {row['run']}: {row['reason']}"), soft_wrap=True)
            progress.update(task, completed=known, good=f"{successes} new successes")

        yield on_row


def _print(figures: dict[str, Any], results: Path, planned: int, interrupted: bool) -> None:
    from doorman.campaign.report.pages import rate_in_words
    from doorman.cli.terminal.display import print_lines

    low = figures["low_friction"]
    print_lines(f"Successes: {rate_in_words(figures['all'])}.")
    if low["runs"]:
        print_lines(f"Doors with less than {low['below_n_m']:g} N m of friction: {rate_in_words(low)}.")
    print_lines(f"Report: {results / 'report.md'}")
    if figures["not_flown"]:
        count, why = len(figures["not_flown"]), " ".join(next(iter(figures["not_flown"].values())).split())
        print_lines(f"Not flown: {count} of {planned} runs; the first: {why}. The same command tries them again.")
    if interrupted:
        flown = figures["all"]["runs"]
        print_lines(f"Interrupted after {flown} of {planned} runs; the same command continues.")
