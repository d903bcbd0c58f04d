"""Rows of the checklist that need no link."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from urdf_variants import write_arm_of

from doorman.flight import Verdict
from doorman.flight.ground.judgements import judge_battery, judge_limits, judge_posture, judge_rotors, judge_setpoints
from doorman.hardware.pixhawk import Battery, EventKind
from doorman.model import Model
from doorman.scenario import Scenario


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
        (Battery(15.6, 10.0, 0.8), {EventKind.BATTERY_SILENT}, Verdict.BAD, "no longer reports"),
    ],
)
def test_a_battery_is_judged_by_its_charge_and_by_what_the_autopilot_thinks_of_it(
    battery: Battery, conditions: frozenset[EventKind], verdict: Verdict, words: str
) -> None:
    check = judge_battery(battery, frozenset(conditions), 0.2)
    assert (check.verdict, words in check.found) == (verdict, True), check
    assert bool(check.advice) is (verdict is not Verdict.GOOD)


def test_no_flight_begins_with_little_more_than_it_is_given_up_at() -> None:
    battery = Battery(15.0, 10.0, 0.35)
    assert judge_battery(battery, frozenset(), 0.2).verdict is Verdict.GOOD
    check = judge_battery(battery, frozenset(), 0.4)
    assert check.verdict is Verdict.BAD and "50%" in check.advice


LOW = (-3.0, -2.5, 0.0)
"""Lowest corner of the fence [m]."""


@pytest.mark.parametrize(
    ("changes", "bad", "words"),
    [
        ({}, None, ""),
        ({"mission.start": "contact"}, "start", "in contact"),
        ({"safety.fence": (LOW, (3.0, 3.5, 0.8))}, "fence", "the way leads to"),
        ({"safety.fence": (LOW, (-0.05, 3.5, 3.0))}, "fence", "the way leads to"),  # what is swung through
    ],
)
def test_what_a_scenario_has_for_a_flight(changes: dict[str, object], bad: str | None, words: str) -> None:
    rows = {check.name: check for check in judge_limits(Model(Scenario.load("paper", changes)))}
    assert [name for name, check in rows.items() if check.verdict is Verdict.BAD] == ([] if bad is None else [bad])
    assert bad is None or words in rows[bad].found


def test_an_arm_that_is_mirrored_is_not_flown() -> None:
    model = Model(Scenario.load("paper"))
    start = np.append(model.start_arm, 0.3)  # a gripper's angle does not count
    assert judge_posture(model, start).verdict is Verdict.GOOD
    assert judge_posture(model, start + 0.2).verdict is Verdict.WARNING
    assert judge_posture(model, model.goal_state[5:]).verdict is Verdict.WARNING, "given up in the swing"
    mirrored = judge_posture(model, -start)
    assert mirrored.verdict is Verdict.BAD and "2.00 rad" in mirrored.found and "directions" in mirrored.advice


def test_a_stick_has_no_posture_to_be_off(tmp_path: Path) -> None:
    model = Model(Scenario.load("push", {"vehicle.urdf": str(write_arm_of(tmp_path / "stick.urdf", 0))}))
    assert judge_posture(model, np.zeros(0)).verdict is Verdict.GOOD


def test_force_to_the_side_needs_attitude_setpoints_and_an_autopilot_that_makes_it() -> None:
    assert judge_rotors("attitude", "").verdict is Verdict.GOOD
    refused = judge_rotors("attitude", "ArduPilot takes thrust along the body's z axis alone")
    assert refused.verdict is Verdict.BAD and "ArduPilot" in refused.found
    assert judge_rotors("position", "").verdict is Verdict.BAD
