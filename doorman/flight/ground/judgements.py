"""Rows of the checklist that are judged by figures alone: poses, battery, setpoints, the arm's posture and the scenario."""

from __future__ import annotations

import math
from collections.abc import Iterator, Set
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.pose_noise import force_noise, most_force_noise
from doorman.control.passage import Passage, has_doorway
from doorman.feasibility import Finding, Report
from doorman.flight.way_back import out_of_the_doorway
from doorman.hardware.pixhawk import Battery, EventKind
from doorman.hardware.pixhawk.dialect import ARDUPILOT
from doorman.hardware.vehicle import Places
from doorman.model import Model


class Verdict(Enum):
    """Result of one check."""

    GOOD = "ok"
    WARNING = "warning"
    BAD = "no"


@dataclass(frozen=True)
class Check:
    """One row of the checklist."""

    name: str
    verdict: Verdict
    found: str
    advice: str = ""


def ready(checks: list[Check]) -> bool:
    """Whether the vehicle may be flown.

    Args:
        checks: Of `preflight`.
    """
    return all(one.verdict is not Verdict.BAD for one in checks)


def row(name: str, good: bool, found: str, advice: str, otherwise: Verdict = Verdict.BAD) -> Check:
    """A row that gives its advice only where it is needed."""
    return Check(name, Verdict.GOOD if good else otherwise, found, "" if good else advice)


_LEAST_BATTERY, _FOR_THE_FLIGHT = 0.3, 0.1
"""Least charge, and its margin above the charge at which the mission is given up."""
_POSTURE, _ELSEWHERE = 0.15, 0.5
"""Angle between the arm's posture and that of the start that is worth a word, and between it and all those that the arm has in
the swing, as after a mission that was given up, that is not flown with [rad]."""
_LOOKS = 20
"""Places of the leaf at which the vehicle's way is looked at."""


def judge_age(latency: float, rate: float, limit: float) -> Check:
    """Row about the poses' age, just before the next one comes: beyond the limit contact is not stable."""
    age = latency + 1.0 / rate if rate > 0.0 else math.inf
    found = (
        f"{latency * 1e3:.1f} ms, up to {age * 1e3:.0f} ms old at {rate:.0f} frames/s; allowed: {limit * 1e3:.0f} ms"
    )
    if not age <= limit:
        return Check("mocap's latency", Verdict.BAD, found,
                     "use faster cameras, or smaller control.position_gain and velocity_gain")  # fmt: skip
    return row("mocap's latency", latency < limit / 2, found, "use a wired network", Verdict.WARNING)


def judge_noise(model: Model, position_noise: float, latency: float, rate: float) -> Check:
    """Row about the poses' noise: where it moves the force of a tip that only presses by too much, the tip leaves the leaf."""
    if not (math.isfinite(position_noise) and math.isfinite(latency) and rate > 0.0):
        return Check("mocap's noise", Verdict.WARNING, "not measured yet", "wait for more frames")
    limit = most_force_noise(model)
    force = force_noise(model, position_noise, max(latency, 0.0), 1.0 / rate)
    found = f"{1e3 * position_noise:.1f} mm of noise make {force:.2f} N at the tip; allowed: {limit:.2f} N"
    return row("mocap's noise", force <= limit, found, "use better or faster cameras, larger markers, or a gripper")


def judge_posture(model: Model, angles: NDArray[np.float64]) -> Check:
    """Row about the arm's posture: a mirrored or badly zeroed servo shows in it."""
    arm = angles[: model.n_arm]
    off = float(np.abs(arm - model.start_arm).max(initial=0.0))
    found = f"{off:.2f} rad off the start posture"
    if min(float(np.abs(arm - state[5:]).max(initial=0.0)) for state in _swing(model)) < _ELSEWHERE:
        return row("arm's posture", off < _POSTURE, found, "the arm moves to its start posture in the air: give it room",
                    Verdict.WARNING)  # fmt: skip
    seen, wanted = (", ".join(f"{angle:.2f}" for angle in one) for one in (arm, model.start_arm))
    advice = (
        "if the arm is in its start posture, check the servos' zeros, directions and ids; else put it there by hand"
    )
    return Check("arm's posture", Verdict.BAD, f"{found}: {seen} rad, start {wanted}", advice)


def judge_battery(battery: Battery, conditions: Set[EventKind], low: float) -> Check:
    """Row about the battery: its charge, or a voltage alone, which tells less, and what the autopilot thinks of it."""
    charge, least = battery.remaining, max(_LEAST_BATTERY, low + _FOR_THE_FLIGHT)
    volts = f"{battery.voltage:.1f} V" if math.isfinite(battery.voltage) else "no voltage"
    advice = f"charge the battery to at least {least:.0%}"
    if EventKind.BATTERY_SILENT in conditions:
        return Check("battery", Verdict.BAD, "the autopilot no longer reports it", "check the battery monitor")
    flat = battery.alarm or EventKind.BATTERY_LOW in conditions
    known = math.isfinite(charge)
    if known or flat:
        words = volts + (f", {charge:.0%}" if known else "") + (", low" if flat else "")
        return row("battery", charge >= least and not flat, words, advice)
    advice = "check the charge yourself: in flight only the autopilot or pixhawk.min_voltage notices a low battery"
    return Check("battery", Verdict.WARNING, f"{volts}, its charge is not reported", advice)


def judge_setpoints(dialect: str, setpoints: str) -> Check:
    """Row about what is sent to the autopilot: position control of ArduPilot that is kept from its place winds up."""
    winds_up = dialect == ARDUPILOT.name and setpoints == "position"
    why = f": {dialect}'s position control winds up against a door and then throws the vehicle back" if winds_up else ""
    return row("setpoints", not winds_up, setpoints + why, "use --setpoints attitude", Verdict.WARNING)


def judge_rotors(setpoints: str, missing: str) -> Check:
    """Row about rotors that push to the side, of a vehicle that has them."""
    if setpoints != "attitude":
        found = f"{setpoints} setpoints carry no force to the side"
        return Check("rotors", Verdict.BAD, found, "use --setpoints attitude")
    return row("rotors", not missing, missing or "the autopilot knows how they are tilted",
               "use PX4 1.14 or newer, and set its CA_ROTOR parameters to the URDF's rotors")  # fmt: skip


def judge_limits(model: Model) -> Iterator[Check]:
    """Rows about the mission's start and fence."""
    start, (low, high) = model.scenario.mission.start, model.scenario.safety.fence
    yield row("start", start == "hover", f"in {start}",
              'set mission.start = "hover": a real vehicle takes off before it comes to the leaf')  # fmt: skip
    outside = [place for place in _way(model) if ((place < low) | (place > high)).any()]
    words = f"; the way leads to {outside[0].round(2)}" if outside else ""
    yield row("fence", not outside, f"{low} to {high} m{words}",
               "set safety.fence around the whole way")  # fmt: skip


def _way(model: Model) -> list[NDArray[np.float64]]:
    """Places of O_B from the pad to the open door and out again, or through, shape (3,) each, world frame [m]."""
    places, still = Places.of(model), np.zeros(3)
    swing = [model.coupling.vehicle_motion(state, still, np.zeros(model.n_arm)).position for state in _swing(model)]
    way = [places.pad, places.hover, *swing, *out_of_the_doorway(model, swing[-1])]
    if model.scenario.mission.then == "through" and has_doorway(model):
        passage = Passage(model)
        way += [passage.entrance, passage.exit]
    return way


def _swing(model: Model) -> list[NDArray[np.float64]]:
    """States from the closed to the open door, shape (5 + n,) each."""
    return [model.on_the_way(float(angle)) for angle in np.linspace(model.start_angle, model.goal_angle, _LOOKS)]


def judge_scenario(report: Report) -> Iterator[Check]:
    """Rows about the scenario."""
    yield row(
        "scenario", report.possible, _in_words(report.errors) or "possible", "run doorman check: it says what to change"
    )
    if report.warnings:
        yield Check("scenario's warnings", Verdict.WARNING, _in_words(report.warnings))


def _in_words(findings: tuple[Finding, ...]) -> str:
    return "; ".join(f"{finding.name}: {finding.message}" for finding in findings)
