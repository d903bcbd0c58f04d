"""`doorman check`: can this scenario work at all?"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated

import typer

from doorman.cli.command import INTERRUPTED, PREPARE, command
from doorman.cli.options import Json, Settings, Source, Vehicle, flag

if TYPE_CHECKING:  # commands import what they run when they run it
    from collections.abc import Iterable

    from doorman.feasibility import Finding


@command(PREPARE, interrupted=INTERRUPTED)
def check(
    scenario: Source = "paper",
    settings: Settings = None,
    vehicle: Vehicle = None,
    audit: Annotated[
        bool, flag("--audit", "Also search for collisions that the constraints allow; takes some seconds.")
    ] = False,
    quick: Annotated[bool, flag("--quick", "Do not fly it in simulation, which takes some seconds.")] = False,
    verbose: Annotated[bool, flag("--verbose", "Also print what is fine, with its numbers and limits.", "-v")] = False,
    as_json: Json = False,
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
    from doorman import feasibility
    from doorman.cli.task import check_links, load_task
    from doorman.cli.terminal.display import flight_progress, print_lines
    from doorman.mission.settled import settled
    from doorman.model import Model

    model = Model(load_task(scenario, settings, vehicle))
    check_links(model, vehicle)
    report = feasibility.check(model, with_audit=audit)
    if not quick:
        with flight_progress(None, shown=not as_json) as on_progress:
            report = settled(model, report, on_progress)
    if as_json:
        typer.echo(json.dumps(report.as_dict(), indent=2))
        return 0 if report.possible else 1
    if shown := report.findings if verbose else report.complaints:
        print_findings(shown)
        print_lines("")
    if not verbose:
        count = len(report.findings)
        print_lines(f"{count - len(shown)} of {count} findings are fine; -v shows them.")
    print_lines(report.sentence)
    return 0 if report.possible else 1


def print_findings(findings: Iterable[Finding], err: bool = False) -> None:
    """Print findings as rows of severity, name, and message with advice."""
    from rich.text import Text

    from doorman.cli.terminal.display import COLORS, print_table
    from doorman.feasibility import Severity

    colors = dict(zip((Severity.OK, Severity.WARNING, Severity.ERROR), COLORS, strict=True))
    rows = ((Text(one.severity.value, style=colors[one.severity]), one.name, one.words) for one in findings)
    print_table(("", "checked", "finding"), rows, err)
