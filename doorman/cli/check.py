"""`doorman check`: can this scenario work at all?"""

from __future__ import annotations

import json
from collections.abc import Sequence

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from doorman.cli.overrides import parse_overrides
from doorman.feasibility import Report, Severity, check
from doorman.scenario import Scenario

_COLORS = {Severity.OK: "green", Severity.WARNING: "yellow", Severity.ERROR: "bold red"}


def check_scenario(source: str, settings: Sequence[str], as_json: bool) -> int:
    """Check a scenario and print what was found.

    Args:
        source: Name or path of the scenario.
        settings: Overrides, `key=value`.
        as_json: Print the findings as JSON and nothing else.

    Returns:
        Exit status: 0 if the scenario is possible, else 1.

    Raises:
        DoormanError: if the input cannot be used.
    """
    report = check(Scenario.load(source, parse_overrides(settings)))
    if as_json:
        typer.echo(json.dumps(report.as_dict(), indent=2))
    else:
        _print(report)
    return 0 if report.possible else 1


def _print(report: Report) -> None:
    table = Table(box=None, pad_edge=False)
    for name in ("", "checked", "finding"):
        table.add_column(name)
    for finding in report.findings:
        color = _COLORS[finding.severity]
        words = f"{finding.message}\n→ {finding.advice}" if finding.advice else finding.message
        table.add_row(Text(finding.severity.value, style=color), Text(finding.name), Text(words))
    console = Console(highlight=False)
    console.print(table)
    console.print(Text(f"\n{_sentence(report)}"), soft_wrap=True)


def _sentence(report: Report) -> str:
    if report.possible:
        return f"The scenario '{report.scenario}' is possible."
    names = ", ".join(finding.name for finding in report.errors)
    return f"The scenario '{report.scenario}' is not possible: {names}."
