"""`doorman campaign`: many flights whose doors, winds and sensors are drawn by chance, and a report of how they went."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.text import Text

from doorman.campaign import Campaign
from doorman.campaign.report.pages import rate_in_words, write_report
from doorman.campaign.results import Row
from doorman.campaign.running import durable_rows, run_campaign
from doorman.cli.overrides import parse_overrides
from doorman.cli.task import check_links, vehicle_values
from doorman.exceptions import DoormanError
from doorman.model import Model


def fly_campaign(
    source: str,
    settings: Sequence[str],
    runs: int | None,
    workers: int | None,
    scheduler: str | None,
    out: Path | None,
    as_json: bool,
    vehicle: str | None = None,
) -> int:
    """Fly what is missing of a campaign, and write its report."""
    if workers is not None and scheduler is not None:
        raise DoormanError(
            "a cluster has its own workers", field="--workers", given=workers, allowed="not with --scheduler"
        )
    campaign = Campaign(source, {**vehicle_values(vehicle), **parse_overrides(settings)}, vehicle)
    scenario = campaign.scenario
    if vehicle is not None:
        check_links(Model(scenario), vehicle)
    planned = scenario.campaign.runs if runs is None else runs
    folder = out or Path("runs") / f"campaign-{scenario.name}"
    folder.mkdir(parents=True, exist_ok=True)
    interrupted = False
    with _progress(planned, shown=not as_json) as on_row:
        try:
            rows = run_campaign(campaign, folder, runs, workers, scheduler, on_row)
        except KeyboardInterrupt:
            interrupted, rows = True, durable_rows(folder)
    figures = write_report(rows, scenario, folder, planned)
    _print(figures, folder, planned, interrupted, as_json)
    return 0 if len(rows) >= planned else 1


@contextmanager
def _progress(runs: int, shown: bool) -> Iterator[Callable[[Row, int, int], None]]:
    """A progress bar on stderr; failures as lines beside it, also where stderr is not a terminal."""
    console = Console(stderr=True, highlight=False)
    successes = 0

    def note(row: Row) -> None:
        nonlocal successes
        successes += row["success"]
        if shown and not row["success"]:
            console.print(Text(f"run {row['run']}: {row['reason']}"), soft_wrap=True)

    if not (shown and console.is_terminal):
        yield lambda row, known, total: note(row)
        return
    columns = (
        TextColumn("{task.completed:.0f} of {task.total:.0f} runs"), BarColumn(), TextColumn("{task.fields[good]}"),
        TimeElapsedColumn(), TimeRemainingColumn(), TextColumn("left"),
    )  # fmt: skip
    with Progress(*columns, console=console, refresh_per_second=2) as progress:
        task = progress.add_task("", total=runs, good="starting (the first run compiles)")

        def on_row(row: Row, known: int, total: int) -> None:
            note(row)
            progress.update(task, completed=known, good=f"{successes} new successes")

        yield on_row


def _print(figures: dict[str, Any], folder: Path, planned: int, interrupted: bool, as_json: bool) -> None:
    if as_json:
        typer.echo((folder / "report.json").read_text(encoding="utf-8"), nl=False)
        return
    console = Console(highlight=False)
    low = figures["low_friction"]
    console.print(Text(f"Successes: {rate_in_words(figures['all'])}."), soft_wrap=True)
    if low["runs"]:
        text = f"Doors with less than {low['below_n_m']:g} N m of friction: {rate_in_words(low)}."
        console.print(Text(text), soft_wrap=True)
    console.print(Text(f"Report: {folder / 'report.md'}"), soft_wrap=True)
    if figures["not_flown"]:
        count, why = len(figures["not_flown"]), next(iter(figures["not_flown"].values()))
        text = f"Not flown: {count} of {planned} runs; the first: {' '.join(why.split())}. The same command tries them again."
        console.print(Text(text), soft_wrap=True)
    if interrupted:
        flown = figures["all"]["runs"]
        console.print(Text(f"Interrupted after {flown} of {planned} runs; the same command continues."), soft_wrap=True)
