"""`doorman check`: what it prints and its exit status."""

from __future__ import annotations

import json

import pytest
from command_line import run

from doorman.feasibility import Finding, Report, Severity


@pytest.mark.parametrize(
    ("start", "possible"),
    [pytest.param("contact", False), pytest.param("hover", False, marks=pytest.mark.slow), ("contact", True)],
)
def test_what_is_possible_has_been_flown(start, possible):
    """The planner opens the door, and a gripper that does not close cannot follow its plan."""
    holds = f"simulation.gripper_force={60.0 if possible else 0.0}"
    result = run("check", "fig4", "--json", "--set", f"mission.start={start}", "--set", holds)
    findings = {one["name"]: one for one in json.loads(result.stdout)["findings"]}
    assert findings["goal reached"]["severity"] == "ok"
    assert (result.exit_code == 0) is possible and (findings["flight"]["severity"] == "ok") is possible
    assert bool(findings["flight"]["advice"]) is not possible


@pytest.mark.parametrize(("words", "asked"), [((), False), (("--audit",), True)])
def test_the_audit_is_made_where_it_is_asked_for(monkeypatch, words, asked):
    made = []
    monkeypatch.setattr(
        "doorman.feasibility.check", lambda _, with_audit: made.append(with_audit) or Report("paper", ())
    )
    assert run("check", "--quick", *words).exit_code == 0
    assert made == [asked]


def test_check_prints_what_to_change_and_with_v_every_finding(monkeypatch):
    findings = (
        Finding("reach", Severity.OK, "the arm reaches [far]", 0.5, 0.1, "m"),
        Finding("tilt", Severity.WARNING, "the plan tilts by 31°", 0.54, 0.5, "rad", "a larger control.max_tilt"),
        Finding("doorway width", Severity.ERROR, "the doorway is too narrow", -0.2, 0.0, "m", "a wider door"),
    )
    monkeypatch.setattr("doorman.feasibility.check", lambda scenario, with_audit: Report("paper", findings))
    quiet, verbose = run("check"), run("check", "-v")
    for result, shown in ((quiet, findings[1:]), (verbose, findings)):
        assert result.exit_code == 1
        for finding in findings:
            assert (finding.message in result.stdout) is (finding in shown)
            assert finding not in shown or (finding.name in result.stdout and finding.advice in result.stdout)
        assert result.stdout.splitlines()[-1] == "The scenario 'paper' is not possible: doorway width."
    assert "1 of 3 findings are fine" in quiet.stdout and "fine" not in verbose.stdout
