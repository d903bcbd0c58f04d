"""Report of a campaign: a page for people (Markdown), the same for programs (JSON), and histograms."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from doorman.campaign.folder import read_not_flown
from doorman.campaign.report.figures import LOW_FRICTION, METRICS, figures
from doorman.campaign.results import DRAWN, Row
from doorman.scenario import Scenario

REPORT_FILES = ("report.md", "report.json", "histograms.png")
"""What the report adds to a campaign's folder."""


def write_report(rows: Sequence[Row], scenario: Scenario, out: Path, planned: int | None = None) -> dict[str, Any]:
    from doorman.campaign.report.histograms import histograms  # needs the extra `viz`
    from doorman.visualization.files import save_as

    found = figures(rows, LOW_FRICTION)
    found["not_flown"] = {str(run): why for run, why in read_not_flown(out).items()}
    (out / "report.json").write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")
    (out / "report.md").write_text(page(rows, found, scenario, planned), encoding="utf-8")
    save_as(histograms(rows, scenario.name), out / "histograms.png")
    return found


def page(rows: Sequence[Row], found: dict[str, Any], scenario: Scenario, planned: int | None = None) -> str:
    """The report as Markdown."""
    parts = [f"# Campaign `{scenario.name}`"]
    if planned is not None and planned != len(rows):
        parts.append(f"Not finished: {len(rows)} of {planned} runs.")
    parts += [_rates(found), _outcomes(found), _quantiles(found), _estimates(found), "![histograms](histograms.png)"]
    parts.append(_drawn(scenario))
    parts.append(_not_flown(found.get("not_flown", {})))
    parts.append(_failures(rows, found))
    return "\n\n".join(part for part in parts if part) + "\n"


def rate_in_words(rate: dict[str, Any]) -> str:
    """A success rate and its interval, such as `190 of 200, 95.0 % (91.0 % to 97.3 %)`."""
    if not rate["runs"]:
        return "no runs"
    lower, upper = rate["interval_95"]
    share = f"{100 * rate['rate']:.1f} % ({100 * lower:.1f} % to {100 * upper:.1f} %)"
    return f"{rate['successes']} of {rate['runs']}, {share}"


def _rates(found: dict[str, Any]) -> str:
    low = found["low_friction"]
    lines = [
        "| | successes |",
        "| --- | --- |",
        f"| all runs | {rate_in_words(found['all'])} |",
        f"| doors with less than {low['below_n_m']:g} N m of friction | {rate_in_words(low)} |",
        f"| runs with a collision | {found['collisions']} |",
        f"| runs that ended in an error | {found['errors']} |",
        f"| failures that ended in a safe retreat | {found['safe_failures']} of {len(found['failures'])} |",
        f"| failures whose told reason is not the true one | {found['wrong_reasons']} of {len(found['failures'])} |",
    ]
    return "\n".join(lines) + "\n\nIn brackets: Wilson's 95 % interval."


def _outcomes(found: dict[str, Any]) -> str:
    lines = ["| outcome | runs |", "| --- | --- |"]
    return "\n".join(lines + [f"| {name} | {count} |" for name, count in found["outcomes"].items()])


def _quantiles(found: dict[str, Any]) -> str:
    lines = ["| | unit | min | 5 % | median | 95 % | max |", "| --- | --- | --- | --- | --- | --- | --- |"]
    for metric in METRICS:
        if metric.column in found["quantiles"]:
            cells = " | ".join(f"{value:.3g}" for value in found["quantiles"][metric.column].values())
            lines.append(f"| {metric.words} | {metric.unit} | {cells} |")
    return "\n".join(lines)


def _estimates(found: dict[str, Any]) -> str:
    if not found["estimates"]:
        return ""
    lines = ["| estimate | runs | median error | within two deviations | good |", "| --- | --- | --- | --- | --- |"]
    for name, entry in found["estimates"].items():
        shares = [f"{100 * entry[key]:.1f} %" if key in entry else "" for key in ("within_two_deviations", "good")]
        lines.append(f"| {name} | {entry['runs']} | {entry['median_error']:.3g} | {shares[0]} | {shares[1]} |")
    return "\n".join(lines) + "\n\nGood: within 25 % or 0.15 N m of the true torque."


def _drawn(scenario: Scenario) -> str:
    lines = [f"Drawn with the seed {scenario.campaign.seed}:", "", "| key | distribution |", "| --- | --- |"]
    for key, distribution in scenario.campaign.vary.items():
        words = ", ".join(f"{name} {value}" for name, value in distribution if value is not None)
        lines.append(f"| `{key}` | {words} |")
    return "\n".join(lines)


def _not_flown(reasons: dict[str, str]) -> str:
    """Runs that are no results: their workers, processes or disks failed."""
    if not reasons:
        return ""
    lines = [f"| {run} | {' '.join(why.split())[:200]} |" for run, why in reasons.items()]
    head = "## Not flown\n\nMachine or software kept these runs from being flown. The same command tries them again."
    return "\n".join([head, "", "| run | why |", "| --- | --- |", *lines])


def _failures(rows: Sequence[Row], found: dict[str, Any]) -> str:
    if not found["failures"]:
        return "## Failures\n\nNone." if rows else ""
    parts = [
        f"## Failures\n\n{len(found['failures'])} runs. The commands fly them again, to the bit on the same machine."
    ]
    drawn = {row["run"]: {k.removeprefix(DRAWN): v for k, v in row.items() if k.startswith(DRAWN)} for row in rows}
    for failed in found["failures"]:
        values = ", ".join(f"{key} {value}" for key, value in drawn[failed["run"]].items())
        text = f"### Run {failed['run']}, seed {failed['seed']}\n\n{failed['reason']}.{_causes(failed)}\n\nDrawn: {values}."
        parts.append(f"{text}\n\n```sh\n{failed['command']}\n```")
    return "\n\n".join(parts)


def _causes(failed: dict[str, Any]) -> str:
    """What in truth may have caused a failure."""
    if not failed["true_causes"]:
        return ""
    wrong = " The told reason is not the true one." if failed["told_truly"] is False else ""
    return f"\n\nTrue: {', '.join(failed['true_causes'])}.{wrong}"
