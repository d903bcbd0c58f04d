"""`doorman check`: can this scenario work at all?"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from doorman.cli.task import check_links, load_task
from doorman.cli.terminal.display import TYPICAL, flight_progress
from doorman.feasibility import Finding, Severity, check
from doorman.mission.settled import settled
from doorman.model import Model

_COLORS = {Severity.OK: "green", Severity.WARNING: "yellow", Severity.ERROR: "bold red"}


def check_scenario(
    source: str,
    settings: Sequence[str],
    as_json: bool,
    with_audit: bool = False,
    vehicle: str | None = None,
    quick: bool = False,
    verbose: bool = False,
) -> int:
    """Check a scenario, fly it if nothing speaks against it, and print what speaks against it, or everything."""
    model = Model(load_task(source, settings, vehicle))
    check_links(model, vehicle)
    report = check(model, with_audit=True) if with_audit else check(model)
    if not quick:
        with flight_progress(TYPICAL, shown=not as_json) as on_progress:
            report = settled(model, report, on_progress)
    if as_json:
        typer.echo(json.dumps(report.as_dict(), indent=2))
    else:
        console = Console(highlight=False)
        if shown := report.findings if verbose else report.complaints:
            console.print(findings_table(shown))
            console.print()
        if not verbose:
            fine, count = len(report.findings) - len(shown), len(report.findings)
            console.print(Text(f"{fine} of {count} findings are fine; -v shows them."), soft_wrap=True)
        console.print(Text(report.sentence), soft_wrap=True)
    return 0 if report.possible else 1


def findings_table(findings: Iterable[Finding]) -> Table:
    """Findings as rows of severity, name, and message with advice."""
    table = Table(box=None, pad_edge=False)
    for name in ("", "checked", "finding"):
        table.add_column(name)
    for finding in findings:
        color = _COLORS[finding.severity]
        table.add_row(Text(finding.severity.value, style=color), Text(finding.name), Text(finding.words))
    return table
