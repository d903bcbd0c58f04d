"""Rows of the checklist that need no link."""

from __future__ import annotations

import pytest

from doorman.flight import Verdict
from doorman.flight.checklist import judge_setpoints


@pytest.mark.parametrize(
    ("dialect", "setpoints", "verdict"),
    [
        ("ArduPilot", "position", Verdict.WARNING),
        ("ArduPilot", "attitude", Verdict.GOOD),
        ("PX4", "position", Verdict.GOOD),
        ("PX4", "attitude", Verdict.GOOD),
    ],
)
def test_ardupilot_is_not_flown_by_position_at_a_door(dialect: str, setpoints: str, verdict: Verdict) -> None:
    check = judge_setpoints(dialect, setpoints)
    assert check.verdict is verdict
    assert ("--setpoints attitude" in check.advice) is (verdict is Verdict.WARNING)
