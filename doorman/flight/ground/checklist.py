"""Pre-flight checklist: every link, its rate and clock, battery, limits, places and the scenario, before anything is armed."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Set
from dataclasses import dataclass
from enum import Enum
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.pose_age import oldest_pose
from doorman.control.estimation.pose_noise import force_noise, most_force_noise
from doorman.control.passage import Passage, has_doorway
from doorman.feasibility import Finding, Report
from doorman.flight.way_back import out_of_the_doorway
from doorman.hardware.dynamixel import ServoFault
from doorman.hardware.pixhawk import Battery, EventKind, SampleStatus
from doorman.hardware.pixhawk.dialect import ARDUPILOT, PX4
from doorman.hardware.scheduling import is_real_time
from doorman.hardware.vehicle import Places, VehicleLinks
from doorman.hardware.vehicle.doubted_mocap import BELIEVED_TURN
from doorman.hardware.vehicle.waiting import TOGETHER, apart, leaning, turned
from doorman.model import Model

_LEAST_RATE = 0.6
"""Share of a rate that must be reached."""
_LEAST_BATTERY, _FOR_THE_FLIGHT = 0.3, 0.1
"""Of its charge, and above what the mission is given up at."""
_POSTURE, _ELSEWHERE = 0.15, 0.5
"""Angle between the arm's posture and that of the start that is worth a word, and between it and all those that the arm has in
the swing, as after a mission that was given up, that is not flown with [rad]."""
_STEP = math.radians(5.0)
"""Between doors' angles at which the vehicle's way is looked at [rad]."""
_PLACE = 0.5
"""Distance between the vehicle and its pad beyond which it does not take off [m]."""
_MOST_LATENCY = 0.03
_LEVEL = math.radians(3.0)
"""By which roll and pitch of cameras and autopilot may differ: a twentieth of the weight points elsewhere [rad]."""
_SETTLED = 0.5
Sample = TypeVar("Sample")
_FLOWN_WITH = ServoFault.VOLTAGE | ServoFault.WARM
"""Of the servos' faults: they are as likely to go in the air."""
_MOST_ROUND_TRIP, _MOST_FOR_STAMPS = 0.05, 0.01
"""Of TIMESYNC: for our map of the autopilot's clock, and for PX4's map of ours, by which it takes the poses' stamps [s]."""


class Verdict(Enum):
    """Of one check."""

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


def preflight(model: Model, links: VehicleLinks, findings: Report) -> list[Check]:
    """Go through the checklist; reads, and changes nothing.

    Args:
        model: Model of the scenario.
        links: Of the vehicle, open for some seconds.
        findings: Of `doorman.feasibility.check` for the scenario; it takes too long to be found while links are open.

    Returns:
        All rows.
    """
    groups = (
        _autopilot(model, links),
        _mocap(model, links),
        _servos(model, links),
        judge_limits(model),
        _place(model, links),
        _computer(),
        judge_scenario(findings),
    )
    return [row for group in groups for row in group]


def _row(name: str, good: bool, found: str, advice: str, otherwise: Verdict = Verdict.BAD) -> Check:
    return Check(name, Verdict.GOOD if good else otherwise, found, "" if good else advice)


def _settled(read: Callable[[], Sample], good: Callable[[Sample], bool]) -> Sample:
    """The first good sample within `_SETTLED`, or the last bad one: a single late answer grounds nobody."""
    deadline = time.monotonic() + _SETTLED
    while not good(sample := read()) and time.monotonic() < deadline:
        time.sleep(0.01)
    return sample


def _autopilot(model: Model, links: VehicleLinks) -> Iterator[Check]:
    autopilot = links.autopilot
    state, status = _settled(autopilot.state, lambda one: one.status is SampleStatus.FRESH), autopilot.status()
    yield _row("autopilot", state.status is SampleStatus.FRESH, f"{status.dialect}, state {state.status.value}",
               "wait until the autopilot's estimator has a position")  # fmt: skip
    yield _row("disarmed", not state.armed, f"{state.mode}, {'armed' if state.armed else 'disarmed'}",
               "land and disarm the vehicle first")  # fmt: skip
    yield _telemetry(links)
    stamps = status.dialect == PX4.name and links.mocap is not None
    most = _MOST_FOR_STAMPS if stamps else _MOST_ROUND_TRIP
    why = "; PX4 ignores the time stamps of poses beyond 10 ms" if stamps else ""
    yield _row("clock", status.synchronised and status.round_trip < most,
               f"offset {status.clock_offset:.3f} s, round trip {status.round_trip * 1e3:.1f} ms",
               "wait, or find what slows the line down" + why,
               Verdict.WARNING if status.synchronised else Verdict.BAD)  # fmt: skip
    yield judge_battery(state.battery, status.conditions, model.scenario.safety.low_battery)
    findings = autopilot.check_parameters()
    yield _row("parameters", not findings, "; ".join(str(one) for one in findings) or "as they should be",
               "set these parameters, then reboot the autopilot", Verdict.WARNING)  # fmt: skip
    if status.on_earth is not None:
        yield _row("place on earth", status.on_earth, "known" if status.on_earth else "none: there is no home to return to",
                   "reboot the autopilot: its estimator started before it had one", Verdict.WARNING)  # fmt: skip
    yield judge_setpoints(status.dialect, autopilot.config.setpoints)
    if model.actuation.fully:
        yield judge_rotors(autopilot.config.setpoints, autopilot.side_force_missing())
    if status.namesake:
        yield Check("system id", Verdict.WARNING,
                    f"another station uses {autopilot.config.system_id}, too: the autopilot may miss that doorman has stopped",
                    "give the other station another id, or close it")  # fmt: skip
    ready_to_arm = autopilot.state().ready_to_arm
    words = "; ".join(("failed", *autopilot.check_again())) if ready_to_arm is False else "passed"
    yield _row("autopilot's own checks", ready_to_arm is not False, "not reported" if ready_to_arm is None else words,
               "repair what it reports, or check its parameters")  # fmt: skip


def _telemetry(links: VehicleLinks) -> Check:
    """Rates of what is flown on, and of what the thrust in hover is measured by."""
    status = links.autopilot.status()
    needed = {name: rate for name, rate in status.asked_rates.items() if status.wanted_rates[name] >= 50.0}
    if links.config.pixhawk.setpoints == "attitude":
        needed["ATTITUDE_TARGET"] = status.asked_rates["ATTITUDE_TARGET"]

    def words(rates: Mapping[str, float]) -> str:
        return ", ".join(f"{name} {status.rates.get(name, 0.0):.0f} of {rate:.0f}/s" for name, rate in rates.items())

    low = {name: rate for name, rate in needed.items() if status.rates.get(name, 0.0) < _LEAST_RATE * rate}
    if low:
        return Check("telemetry", Verdict.BAD, words(low), "use a faster line, or ask for lower rates")
    less = {name: status.wanted_rates[name] for name, rate in needed.items() if rate < status.wanted_rates[name]}
    if less:
        return Check(
            "telemetry", Verdict.WARNING, words(less), "the autopilot refused the wanted rates: raise SCHED_LOOP_RATE"
        )
    return Check("telemetry", Verdict.GOOD, "rates as asked for")


def _mocap(model: Model, links: VehicleLinks) -> Iterator[Check]:
    if links.mocap is None:
        yield Check("mocap", Verdict.WARNING, "none: the flight uses the autopilot's own estimate")
        return
    pose, figures = _settled(links.mocap.read, lambda sample: sample.fresh), links.mocap.statistics
    yield _row("mocap", pose.fresh, f"pose {pose.quality.value}, {figures.frame_rate:.1f} frames/s",
               "make sure that the cameras see the object")  # fmt: skip
    yield judge_age(figures.latency, figures.frame_rate, oldest_pose(model.scenario.control))
    if model.scenario.contact.kind == "push":
        yield judge_noise(model, figures.position_noise, figures.latency, figures.frame_rate)
    off = apart(links)
    yield _row("mocap and autopilot", off < TOGETHER, f"{off * 1e3:.0f} mm apart",
               "let the autopilot use the poses: check its parameters, then reboot it")  # fmt: skip
    turn = turned(links)
    yield _row("mocap's and autopilot's attitude", turn < BELIEVED_TURN, f"{math.degrees(turn):.0f}° apart",
               "align the object's axes with the autopilot's, and let it take its yaw from the poses")  # fmt: skip
    lean = leaning(links)
    yield _row("mocap's and autopilot's level", lean < _LEVEL, f"{math.degrees(lean):.1f}° apart",
               "define the object again while the vehicle stands level, or calibrate the autopilot's level")  # fmt: skip


def judge_age(latency: float, rate: float, limit: float) -> Check:
    """Row about the poses' age, just before the next one comes: beyond the limit contact is not stable.

    Args:
        latency: From exposure to arrival [s].
        rate: Frames per second [1/s].
        limit: Of the age, by the controller's gains [s].
    """
    age = latency + 1.0 / rate if rate > 0.0 else math.inf
    found = (
        f"{latency * 1e3:.1f} ms, up to {age * 1e3:.0f} ms old at {rate:.0f} frames/s; allowed: {limit * 1e3:.0f} ms"
    )
    if not age <= limit:
        return Check(
            "mocap's latency",
            Verdict.BAD,
            found,
            "use faster cameras, or smaller control.position_gain and velocity_gain",
        )
    return _row("mocap's latency", latency < _MOST_LATENCY, found, "use a wired network", Verdict.WARNING)


def judge_noise(model: Model, position_noise: float, latency: float, rate: float) -> Check:
    """Row about the poses' noise: where it moves the force of a tip that pushes by too much, the tip leaves the leaf.

    Args:
        model: Model of the scenario.
        position_noise: Measured, on every axis [m].
        latency: From exposure to arrival [s].
        rate: Frames per second [1/s].
    """
    if not (math.isfinite(position_noise) and math.isfinite(latency) and rate > 0.0):
        return Check("mocap's noise", Verdict.WARNING, "not measured yet", "wait for more frames")
    limit = most_force_noise(model)
    force = force_noise(model, position_noise, max(latency, 0.0), 1.0 / rate)
    found = f"{1e3 * position_noise:.1f} mm of noise make {force:.2f} N at the tip; allowed: {limit:.2f} N"
    return _row("mocap's noise", force <= limit, found, "use better or faster cameras, larger markers, or a gripper")


def _servos(model: Model, links: VehicleLinks) -> Iterator[Check]:
    sample = _settled(links.servos.read, lambda sample: sample.fresh and not sample.fault)
    names = ", ".join(str(servo.servo_id) for servo in links.servos.servos)
    yield _row("servos", sample.fresh and not sample.fault, f"{names}: {sample.state.value}, age {sample.age * 1e3:.0f} ms"
               + (f", {sample.fault}" if sample.fault else ""), "see docs/hardware/servos.md",
               Verdict.WARNING if sample.fresh and not sample.fault & ~_FLOWN_WITH else Verdict.BAD)  # fmt: skip
    hottest = float(np.max(sample.temperatures))
    yield _row("servos' temperature", hottest < links.config.servos.warm_temperature, f"up to {hottest:.0f} °C",
               "let them cool down", Verdict.WARNING)  # fmt: skip
    yield judge_posture(model, sample.angles)


def judge_posture(model: Model, angles: NDArray[np.float64]) -> Check:
    """Row about the arm's posture: a mirrored or badly zeroed servo shows in it.

    Args:
        model: Model of the scenario.
        angles: Of the arm's joints, and a gripper's, shape (n,) or (n + 1,) [rad].
    """
    arm = angles[: model.n_arm]
    off = float(np.abs(arm - model.start_arm).max())
    found = f"{off:.2f} rad off the start posture"
    if min(float(np.abs(arm - state[5:]).max()) for state in _swing(model)) < _ELSEWHERE:
        return _row("arm's posture", off < _POSTURE, found, "the arm moves to its start posture in the air: give it room",
                    Verdict.WARNING)  # fmt: skip
    seen, wanted = (", ".join(f"{angle:.2f}" for angle in one) for one in (arm, model.start_arm))
    advice = (
        "if the arm is in its start posture, check the servos' zeros, directions and ids; else put it there by hand"
    )
    return Check("arm's posture", Verdict.BAD, f"{found}: {seen} rad, start {wanted}", advice)


def judge_battery(battery: Battery, conditions: Set[EventKind], low: float) -> Check:
    """Row about the battery: its charge, or a voltage alone, which tells less, and what the autopilot thinks of it.

    Args:
        battery: As reported.
        conditions: That hold on the link to the autopilot.
        low: Share of its charge at which the mission is given up.
    """
    charge, least = battery.remaining, max(_LEAST_BATTERY, low + _FOR_THE_FLIGHT)
    volts = f"{battery.voltage:.1f} V" if math.isfinite(battery.voltage) else "no voltage"
    advice = f"charge the battery to at least {least:.0%}"
    if EventKind.BATTERY_SILENT in conditions:
        return Check("battery", Verdict.BAD, "the autopilot no longer reports it", "check the battery monitor")
    flat = battery.alarm or EventKind.BATTERY_LOW in conditions
    if math.isfinite(charge):
        words = f"{volts}, {charge:.0%}" + (", low" if flat else "")
        return _row("battery", charge >= least and not flat, words, advice)
    if flat:
        return Check("battery", Verdict.BAD, f"{volts}, low", advice)
    return Check(
        "battery",
        Verdict.WARNING,
        f"{volts}, its charge is not reported",
        "check the charge yourself: in flight only the autopilot or pixhawk.min_voltage notices a low battery",
    )


def judge_setpoints(dialect: str, setpoints: str) -> Check:
    """Row about what is sent to the autopilot: position control of ArduPilot that is kept from its place winds up.

    Args:
        dialect: Name of the autopilot's dialect.
        setpoints: "attitude" or "position".
    """
    winds_up = dialect == ARDUPILOT.name and setpoints == "position"
    found = (
        f"{setpoints}: {dialect}'s position control winds up against a door and then throws the vehicle back"
        if winds_up
        else setpoints
    )
    return _row("setpoints", not winds_up, found, "use --setpoints attitude", Verdict.WARNING)


def judge_rotors(setpoints: str, missing: str) -> Check:
    """Row about rotors that push to the side, of a vehicle that has them.

    Args:
        setpoints: "attitude" or "position".
        missing: Why the autopilot makes no force to the side; empty if it does.
    """
    if setpoints != "attitude":
        return Check(
            "rotors", Verdict.BAD, f"{setpoints} setpoints carry no force to the side", "use --setpoints attitude"
        )
    found = missing or "the autopilot knows how they are tilted"
    return _row(
        "rotors", not missing, found, "use PX4 1.14 or newer, and set its CA_ROTOR parameters to the URDF's rotors"
    )


def judge_limits(model: Model) -> Iterator[Check]:
    """Rows about the mission's start and fence.

    Args:
        model: Model of the scenario.
    """
    start, limits = model.scenario.mission.start, model.scenario.safety
    yield _row(
        "start",
        start == "hover",
        f"in {start}",
        'set mission.start = "hover": a real vehicle takes off before it comes to the leaf',
    )
    outside = [place for place in _way(model) if ((place < limits.fence_low) | (place > limits.fence_high)).any()]
    words = f"; the way leads to {outside[0].round(2)}" if outside else ""
    yield _row("fence", not outside, f"{limits.fence_low} to {limits.fence_high} m{words}",
               "set safety.fence_low and safety.fence_high around the whole way")  # fmt: skip


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
    first, last = model.start_angle, model.goal_angle
    return [model.on_the_way(float(angle)) for angle in np.linspace(first, last, 2 + int(abs(first - last) / _STEP))]


def _place(model: Model, links: VehicleLinks) -> Iterator[Check]:
    pad, state = Places.of(model).pad, links.autopilot.state()
    off = float(np.linalg.norm(state.position[:2] - pad[:2]))
    yield _row("place", off < _PLACE, f"{off:.2f} m from the pad at x {pad[0]:.2f}, y {pad[1]:.2f}",
               f"put the vehicle within {_PLACE:g} m of the pad")  # fmt: skip


def _computer() -> Iterator[Check]:
    yield _row("scheduling", is_real_time(), "real time" if is_real_time() else "ordinary",
               "run as root or with the limit rtprio, so that no program delays it", Verdict.WARNING)  # fmt: skip


def judge_scenario(report: Report) -> Iterator[Check]:
    """Rows about the scenario.

    Args:
        report: Of `doorman.feasibility.check`.
    """
    yield _row(
        "scenario", report.possible, _told(report.errors) or "possible", "run doorman check: it says what to change"
    )
    if report.warnings:
        yield Check("scenario's warnings", Verdict.WARNING, _told(report.warnings))


def _told(findings: tuple[Finding, ...]) -> str:
    return "; ".join(f"{finding.name}: {finding.message}" for finding in findings)
