"""Rows of the checklist that need no link."""

from __future__ import annotations

import pytest

from doorman.flight import Verdict
from doorman.flight.checklist import judge_battery, judge_setpoints
from doorman.hardware.pixhawk import Battery, EventKind


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


FLAT = frozenset({EventKind.BATTERY_LOW})


@pytest.mark.parametrize(
    ("battery", "conditions", "verdict", "words"),
    [
        (Battery(15.6, 10.0, 0.8), (), Verdict.GOOD, "80%"),
        (Battery(14.1, 10.0, 0.25), (), Verdict.BAD, "25%"),
        (Battery(14.1, 10.0, 0.5, alarm=True), (), Verdict.BAD, "low"),
        (Battery(14.1, 10.0, 0.5), FLAT, Verdict.BAD, "low"),
        (Battery(15.6), (), Verdict.WARNING, "15.6 V, its charge is not reported"),
        (Battery(13.0), FLAT, Verdict.BAD, "13.0 V, low"),
        (Battery(13.0, alarm=True), (), Verdict.BAD, "13.0 V, low"),
        (Battery(), (), Verdict.WARNING, "no voltage, its charge is not reported"),
        (Battery(15.6, 10.0, 0.8), {EventKind.BATTERY_SILENT}, Verdict.BAD, "not reported any more"),
    ],
)
def test_a_battery_is_judged_by_its_charge_and_by_what_the_autopilot_thinks_of_it(
    battery: Battery, conditions: frozenset[EventKind], verdict: Verdict, words: str
) -> None:
    check = judge_battery(battery, frozenset(conditions))
    assert (check.verdict, words in check.found) == (verdict, True), check
    assert bool(check.advice) is (verdict is not Verdict.GOOD)
