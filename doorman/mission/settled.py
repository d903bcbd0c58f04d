"""The flight that settles a check: what nothing speaks against is flown once in the plant, as the scenario states it."""

from __future__ import annotations

import dataclasses

from doorman.exceptions import DoormanError
from doorman.feasibility import Finding, Report
from doorman.feasibility.report import Severity
from doorman.kinematics.doors.joint_friction import with_plants_friction
from doorman.mission.mission import OnProgress
from doorman.mission.simulate import simulate
from doorman.model import Model
from doorman.summary import verdict
from doorman.summary.outcome import OPEN_TOLERANCE, is_cut_off

LONGEST = 22.0
"""Simulated time that is flown at most: an idle core flies it in about 5 s [s]."""


def settled(model: Model, report: Report, on_progress: OnProgress | None = None) -> Report:
    """Fly a scenario that the check calls possible, for `LONGEST` at most, and add how that ended.

    The plant is that of `simulate` with the seed 0: what is possible in the report has been flown, and nothing was touched. A
    joint of unknown friction is flown with the least and the largest of a usual one, each from the touch until the leaf
    rests at the goal. A flight that is not over by then is a warning.
    """
    if not report.possible or "simulator" in {finding.name for finding in report.warnings}:
        return report
    first, *others = ends = _ends(model)
    longest = LONGEST / len(ends)
    finding = _flown(first, report, on_progress, longest, unknown=bool(others))
    for end in others:
        finding = _flown(end, report, on_progress, longest, unknown=True) if finding.ok else finding
    return dataclasses.replace(report, findings=(*report.findings, finding))


def _ends(model: Model) -> tuple[Model, ...]:
    """Models of what may stand there."""
    if model.friction.known:
        return (model,)
    ends, scenario = (model.friction.least, model.friction.largest), model.scenario
    if model.true_door is model.door and scenario.mission.then == "return":
        at_the_leaf = scenario.mission.model_copy(update={"start": "contact", "then": "stay"})
        scenario = scenario.model_copy(update={"mission": at_the_leaf})
    return tuple(Model(with_plants_friction(scenario, end / model.door.per_angle)) for end in ends)


def _flown(model: Model, report: Report, on_progress: OnProgress | None, longest: float, unknown: bool) -> Finding:
    """One flight."""
    door, per_angle = model.door, model.door.per_angle
    error, advice, unit = float("nan"), "", "rad" if door.unit == "rad" else "m"
    severity = Severity.ERROR
    try:
        recording = simulate(model, longest, on_progress=on_progress, force=True, report=report)
        summary = recording.summary or {}
        opened, words = verdict(summary)
        left = model.travel.left(float(recording["truth"]["door_angle"][-1]))
        error = abs(left)
        if opened:
            severity = Severity.OK
        elif is_cut_off(summary) and left > -OPEN_TOLERANCE:
            severity = Severity.WARNING
            words = f"not over after {longest:g} s of flight, in which nothing was touched. {words}"
    except DoormanError as failure:
        opened, words = False, f"flown for 0 s: {failure}"
    if unknown:
        words = f"with {door.torque_in_words(model.friction.expected)} of friction: {words}"
    if not opened:
        near = ", ".join(finding.name for finding in report.warnings)
        advice = "watch it with doorman open --force" + (f"; the check warns of {near}" if near else "")
        advice += "; begin nearer to the shipped scenarios in start, goal and planner.weights"
    if unknown and not opened:
        advice = f"write what the hinge has into door.friction [{'N' if door.slides else 'N m'}], which no file names"
    return Finding("flight", severity, words, per_angle * error, per_angle * OPEN_TOLERANCE, unit, advice)
