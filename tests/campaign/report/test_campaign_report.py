"""The report of a campaign: its figures, its page, its histograms, and the command that makes it."""

from __future__ import annotations

import json
from typing import Any

import pytest
from typer.testing import CliRunner

from doorman.campaign.report.figures import estimates, figures, wilson_interval
from doorman.campaign.report.pages import REPORT_FILES, page, rate_in_words, write_report
from doorman.cli import app
from doorman.scenario import Scenario


def row(run: int, success: bool = True, friction: float | None = 1.0, **more: Any) -> dict[str, Any]:
    reason, outcome = ("", "completed") if success else ("given up: the door does not move", "given up")
    return {
        "run": run, "seed": 100 + run, "success": success, "safe": True, "outcome": outcome, "reason": reason,
        "final_error_deg": 0.1 * run, "error": None, "command": f"doorman open push --seed {100 + run}", "friction": friction,
        "summary.contact_fraction": 0.99, "summary.time_to_open_s": 15.0 if success else None, "summary.collisions": 0,
        "drawn.simulation.door_mass": 7.5,
    } | more  # fmt: skip


def estimated(value: float, true: float, deviation: float, name: str = "friction") -> dict[str, Any]:
    numbers = {"value": value, "true": true, "deviation": deviation}
    return {f"summary.estimates.{name}.{key}": number for key, number in numbers.items()}


def test_rates_are_counted_and_slippery_doors_by_themselves():
    rows = [row(k, success=k != 3, friction=0.2 + 0.1 * k) for k in range(10)]
    rows[5]["summary.collisions"] = 2
    found = figures(rows, low_friction=0.55)
    assert found["all"] == {"runs": 10, "successes": 9, "rate": 0.9, "interval_95": list(wilson_interval(9, 10))}
    assert (found["low_friction"]["runs"], found["low_friction"]["successes"]) == (4, 3)
    assert (found["collisions"], found["errors"]) == (1, 0)
    assert found["outcomes"] == {"completed": 9, "given up": 1}
    assert found["safe_failures"] == 1
    assert found["quantiles"]["final_error_deg"]["median"] == pytest.approx(0.45)
    assert found["quantiles"]["summary.time_to_open_s"]["max"] == 15.0
    assert [one["run"] for one in found["failures"]] == [3]
    json.dumps(found)


def test_doors_whose_friction_nobody_knows_are_not_slippery():
    assert figures([row(0, friction=None)], 10.0)["low_friction"]["runs"] == 0


def test_estimates_are_held_against_their_own_deviations():
    rows = [row(k, **estimated(1.0 + error, 1.0, 0.1)) for k, error in enumerate((0.0, 0.19, -0.19, 0.21))]
    found = estimates([*rows, row(9)])
    assert found["friction"] == {"runs": 4, "median_error": pytest.approx(0.19), "within_two_deviations": 0.75}
    assert list(found) == ["friction"]
    torques = [row(k, **estimated(value, true, 1.0, "torque")) for k, (value, true) in
               enumerate(((1.2, 1.0), (1.3, 1.0), (0.14, 0.0), (0.16, 0.0), (-2.4, -2.0)))]  # fmt: skip
    assert estimates(torques)["torque"]["good"] == pytest.approx(0.6)


def test_the_page_tells_every_failure_with_its_command():
    rows = [row(0), row(1, success=False), row(2)]
    text = page(rows, figures(rows, 0.5), Scenario.load("push_campaign"), planned=5)
    assert "Not finished: 3 of 5 runs." in text
    assert "| all runs | 2 of 3, 66.7 % (20.8 % to 93.9 %) |" in text
    assert "### Run 1, seed 101\n\ngiven up: the door does not move.\n\nDrawn: simulation.door_mass 7.5." in text
    assert "```sh\ndoorman open push --seed 101\n```" in text
    assert "| `simulation.door_friction` | min 0.3, max 2.0 |" in text


def test_a_campaign_without_failures_or_without_runs():
    scenario = Scenario.load("push_campaign")
    assert "## Failures\n\nNone." in page([row(0)], figures([row(0)], 0.5), scenario)
    assert rate_in_words(figures([], 0.5)["all"]) == "no runs"
    assert "no runs" in page([], figures([], 0.5), scenario, planned=3)


@pytest.mark.parametrize("count", [0, 1, 25])
def test_the_report_is_written(tmp_path, count):
    rows = [row(k, success=k % 5 != 1, **estimated(1.0 + 0.01 * k, 1.0, 0.1)) for k in range(count)]
    found = write_report(rows, Scenario.load("push_campaign"), tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == set(REPORT_FILES)
    assert json.loads((tmp_path / "report.json").read_text()) == found
    assert (tmp_path / "histograms.png").read_bytes().startswith(b"\x89PNG")


def test_the_command_reports_what_was_flown(task, flown):
    out, _ = flown
    outcome = CliRunner().invoke(app, ["campaign", str(task), "--out", str(out)])
    assert outcome.exit_code == 0, outcome.output
    assert "Successes: 0 of 5, 0.0 % (0.0 % to 43.4 %)." in outcome.output
    assert "Doors with less than 0.5 N m of friction: 0 of 2" in outcome.output
    assert "ScenarioError" in (out / "report.md").read_text()
    as_json = CliRunner().invoke(app, ["campaign", str(task), "--out", str(out), "--json"])
    assert json.loads(as_json.stdout)["all"]["runs"] == 5


def test_a_cluster_has_its_own_workers(task, tmp_path):
    words = ["--workers", "2", "--scheduler", "tcp://127.0.0.1:1"]
    outcome = CliRunner().invoke(app, ["campaign", str(task), "--out", str(tmp_path / "out"), *words])
    assert outcome.exit_code == 2
    assert "--workers" in outcome.stderr and len(outcome.stderr.splitlines()) == 1
