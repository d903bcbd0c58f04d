"""Report of a campaign: a page for people (Markdown), the same for programs (JSON), and histograms."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
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
    parts += [
        _rates(found),
        _table(("outcome", "runs"), found["outcomes"].items()),
        _quantiles(found),
        _estimates(found),
        "![histograms](histograms.png)",
    ]
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


def _table(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(map(str, cells))} |" for cells in lines)


def _rates(found: dict[str, Any]) -> str:
    low, failures = found["low_friction"], len(found["failures"])
    rows = (
        ("all runs", rate_in_words(found["all"])),
        (f"doors with less than {low['below_n_m']:g} N m of friction", rate_in_words(low)),
        ("runs with a collision", found["collisions"]),
        ("runs that ended in an error", found["errors"]),
        ("failures that ended in a safe retreat", f"{found['safe_failures']} of {failures}"),
        ("failures whose stated reason is not the true one", f"{found['wrong_reasons']} of {failures}"),
    )
    return _table(("", "successes"), rows) + "\n\nIn brackets: Wilson's 95 % interval."


def _quantiles(found: dict[str, Any]) -> str:
    rows = (
        (metric.words, metric.unit, *(f"{value:.3g}" for value in found["quantiles"][metric.column].values()))
        for metric in METRICS
        if metric.column in found["quantiles"]
    )
    return _table(("", "unit", "min", "5 %", "median", "95 %", "max"), rows)


def _estimates(found: dict[str, Any]) -> str:
    if not found["estimates"]:
        return ""
    rows = []
    for name, entry in found["estimates"].items():
        shares = [f"{100 * entry[key]:.1f} %" if key in entry else "" for key in ("within_two_deviations", "good")]
        rows.append((name, entry["runs"], f"{entry['median_error']:.3g}", *shares))
    return (
        _table(("estimate", "runs", "median error", "within two deviations", "good"), rows)
        + "\n\nGood: within 25 % or 0.15 N m of the true torque."
    )


def _drawn(scenario: Scenario) -> str:
    rows = (
        (f"`{key}`", ", ".join(f"{name} {value}" for name, value in distribution if value is not None))
        for key, distribution in scenario.campaign.vary.items()
    )
    return f"Drawn with the seed {scenario.campaign.seed}:\n\n{_table(('key', 'distribution'), rows)}"


def _not_flown(reasons: dict[str, str]) -> str:
    """Runs that are no results: their workers, processes or disks failed."""
    if not reasons:
        return ""
    head = "## Not flown\n\nMachine or software kept these runs from being flown. The same command tries them again."
    return f"{head}\n\n{_table(('run', 'why'), ((run, ' '.join(why.split())[:200]) for run, why in reasons.items()))}"


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
    wrong = " The stated reason is not the true one." if failed["told_truly"] is False else ""
    return f"\n\nTrue: {', '.join(failed['true_causes'])}.{wrong}"
