"""`doorman campaign`: its arguments and its help."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from doorman.cli.arguments import Settings, Source, Vehicle
from doorman.cli.terminal import panels


def add_campaign_command(app: typer.Typer, leave: Callable[[Callable[[], int]], None]) -> None:
    @app.command("campaign", rich_help_panel=panels.FLY)
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
        as_json: Annotated[
            bool, typer.Option("--json", help="Print the report's figures as JSON; no progress.")
        ] = False,
    ) -> None:
        """Fly a scenario many times, with random doors, winds and sensors, and report how often it works.

        The scenario's table campaign.vary defines the distributions. The values of run i depend only on campaign.seed and on i.

        The command writes a folder: the report (report.md, report.json, histograms.png), one row per run (results.parquet), and
        one file per run (runs). The same command continues an interrupted campaign where it stopped. A larger number of runs
        continues a finished campaign. The report lists every failure with the command that flies it again.

        The exit status is 0 if all runs were flown, with or without success.
        """

        def command() -> int:
            from doorman.cli.simulated.campaign import fly_campaign

            return fly_campaign(scenario, settings or [], runs, workers, scheduler, out, as_json, vehicle)

        leave(command)
