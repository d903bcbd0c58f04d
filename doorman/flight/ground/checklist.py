"""Pre-flight checklist: every link, its rate and clock, battery, limits, places and the scenario, before anything is armed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TypeVar

import numpy as np

from doorman.clocks import HELD_UP, LOOK
from doorman.control.estimation.pose_age import oldest_pose
from doorman.control.estimation.pose_noise import most_force_noise
from doorman.dynamics.attitude_loop import TESTED_DEAD_TIME, TESTED_LAG
from doorman.feasibility import Report
from doorman.flight.ground.door import measured_door
from doorman.flight.ground.judgements import (
    Check,
    Verdict,
    judge_age,
    judge_battery,
    judge_limits,
    judge_noise,
    judge_posture,
    judge_rotors,
    judge_scenario,
    judge_setpoints,
    row,
)
from doorman.hardware.dynamixel import ServoFault
from doorman.hardware.pixhawk import SampleStatus
from doorman.hardware.pixhawk.dialect import PX4
from doorman.hardware.pixhawk.link.rates import ENOUGH
from doorman.hardware.scheduling import is_real_time
from doorman.hardware.vehicle import Places, VehicleLinks
from doorman.hardware.vehicle.doubt import BELIEVED_TURN
from doorman.hardware.vehicle.waiting import TOGETHER, apart, leaning, turned
from doorman.model import Model

_PLACE = 0.5
"""Distance between the vehicle and its pad beyond which it does not take off [m]."""
_LEVEL = math.radians(3.0)
"""Largest difference of roll or pitch between cameras and autopilot: a twentieth of the weight then points elsewhere [rad]."""
Sample = TypeVar("Sample")
_FLOWN_WITH = ServoFault.VOLTAGE | ServoFault.WARM
"""Faults of servos that do not keep a flight on the ground: they may disappear in the air as well."""
_MOST_ROUND_TRIP, _MOST_FOR_STAMPS = 0.05, 0.01
"""Largest TIMESYNC round trips: for our map of the autopilot's clock, and for PX4's map of ours, used for poses' stamps [s]."""


def preflight(model: Model, links: VehicleLinks, findings: Report) -> list[Check]:
    """Go through the checklist; reads, and changes nothing.

    Args:
        model: Model of the scenario.
        links: Of the vehicle, open for some seconds.
        findings: Of `doorman.feasibility.check` for the scenario; it takes too long to be found while links are open.

    Returns:
        All rows.
    """
    return [
        *_autopilot(model, links),
        *_mocap(model, links),
        *_servos(model, links),
        *judge_limits(model),
        *measured_door(model, links),
        _place(model, links),
        row("scheduling", is_real_time(), "real time" if is_real_time() else "ordinary",
            "run as root or with the limit rtprio, so that no program delays it", Verdict.WARNING),
        *judge_scenario(findings),
        _attitude_loop(model, links),
    ]  # fmt: skip


def _settled(links: VehicleLinks, read: Callable[[], Sample], good: Callable[[Sample], bool]) -> Sample:
    """The first good sample within `HELD_UP`, or the last bad one: a single late answer grounds no vehicle."""
    deadline = links.clock.now() + HELD_UP
    while not good(sample := read()) and links.clock.now() < deadline:
        links.clock.sleep(LOOK)
    return sample


def _autopilot(model: Model, links: VehicleLinks) -> Iterator[Check]:
    autopilot = links.autopilot
    state, status = _settled(links, autopilot.state, lambda one: one.status is SampleStatus.FRESH), autopilot.status()
    yield row("autopilot", state.status is SampleStatus.FRESH, f"{status.dialect}, state {state.status.value}",
               "wait until the autopilot's estimator has a position")  # fmt: skip
    yield row("disarmed", not state.armed, f"{state.mode}, {'armed' if state.armed else 'disarmed'}",
               "land and disarm the vehicle first")  # fmt: skip
    yield _telemetry(links)
    stamps = status.dialect == PX4.name and links.mocap is not None
    most = _MOST_FOR_STAMPS if stamps else _MOST_ROUND_TRIP
    why = "; PX4 ignores the time stamps of poses beyond 10 ms" if stamps else ""
    yield row("clock", status.synchronised and status.round_trip < most,
               f"offset {status.clock_offset:.3f} s, round trip {status.round_trip * 1e3:.1f} ms",
               "wait, or find what slows the line down" + why,
               Verdict.WARNING if status.synchronised else Verdict.BAD)  # fmt: skip
    yield judge_battery(state.battery, status.conditions, model.scenario.safety.low_battery)
    findings = autopilot.check_parameters()
    yield row("parameters", not findings, "; ".join(str(one) for one in findings) or "as they should be",
               "set these parameters, then reboot the autopilot", Verdict.WARNING)  # fmt: skip
    if status.on_earth is not None:
        yield row("place on earth", status.on_earth, "known" if status.on_earth else "none: there is no home to return to",
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
    yield row("autopilot's own checks", ready_to_arm is not False, "not reported" if ready_to_arm is None else words,
               "repair what it reports, or check its parameters")  # fmt: skip


def _telemetry(links: VehicleLinks) -> Check:
    """Rates of what is flown on, and of what the thrust in hover is measured by."""
    status = links.autopilot.status()
    needed = {name: rate for name, rate in status.asked_rates.items() if status.wanted_rates[name] >= 50.0}
    if links.config.pixhawk.setpoints == "attitude":
        needed["ATTITUDE_TARGET"] = status.asked_rates["ATTITUDE_TARGET"]

    def words(names: Iterable[str], wanted: Mapping[str, float]) -> str:
        return ", ".join(f"{name} {status.rates.get(name, 0.0):.0f} of {wanted[name]:.0f}/s" for name in names)

    low = [name for name, rate in needed.items() if status.rates.get(name, 0.0) < ENOUGH * rate]
    if low:
        return Check("telemetry", Verdict.BAD, words(low, needed), "use a faster line, or ask for lower rates")
    less = [name for name, rate in needed.items() if rate < status.wanted_rates[name]]
    return row("telemetry", not less, words(less, status.wanted_rates) or "rates as requested",
               "the autopilot refused the wanted rates: raise SCHED_LOOP_RATE", Verdict.WARNING)  # fmt: skip


def _mocap(model: Model, links: VehicleLinks) -> Iterator[Check]:
    if links.mocap is None:
        yield Check("mocap", Verdict.WARNING, "none: the flight uses the autopilot's own estimate")
        return
    pose, figures = _settled(links, links.mocap.read, lambda sample: sample.fresh), links.mocap.statistics
    yield row("mocap", pose.fresh, f"pose {pose.quality.value}, {figures.frame_rate:.1f} frames/s",
               "make sure that the cameras see the object")  # fmt: skip
    yield judge_age(figures.latency, figures.frame_rate, oldest_pose(model.scenario.control))
    if math.isfinite(most_force_noise(model)):
        yield judge_noise(model, figures.position_noise, figures.latency, figures.frame_rate)
    off = apart(links)
    yield row("mocap and autopilot", off < TOGETHER, f"{off * 1e3:.0f} mm apart",
               "let the autopilot use the poses: check its parameters, then reboot it")  # fmt: skip
    turn = turned(links)
    yield row("mocap's and autopilot's attitude", turn < BELIEVED_TURN, f"{math.degrees(turn):.0f}° apart",
               "align the object's axes with the autopilot's, and let it take its yaw from the poses")  # fmt: skip
    lean = leaning(links)
    yield row("mocap's and autopilot's level", lean < _LEVEL, f"{math.degrees(lean):.1f}° apart",
               "define the object again while the vehicle stands level, or calibrate the autopilot's level")  # fmt: skip


def _servos(model: Model, links: VehicleLinks) -> Iterator[Check]:
    if not links.config.servos.n:
        return
    sample = _settled(links, links.servos.read, lambda sample: sample.fresh and not sample.fault)
    names = ", ".join(str(servo.servo_id) for servo in links.servos.servos)
    yield row("servos", sample.fresh and not sample.fault, f"{names}: {sample.state.value}, age {sample.age * 1e3:.0f} ms"
               + (f", {sample.fault}" if sample.fault else ""), "see docs/hardware/servos.md",
               Verdict.WARNING if sample.fresh and not sample.fault & ~_FLOWN_WITH else Verdict.BAD)  # fmt: skip
    hottest = float(np.max(sample.temperatures))
    yield row("servos' temperature", hottest < links.config.servos.warm_temperature, f"up to {hottest:.0f} °C",
               "let them cool down", Verdict.WARNING)  # fmt: skip
    yield judge_posture(model, sample.angles)


def _place(model: Model, links: VehicleLinks) -> Check:
    pad, state = Places.of(model).pad, links.autopilot.state()
    off = float(np.linalg.norm(state.position[:2] - pad[:2]))
    return row("place", off < _PLACE, f"{off:.2f} m from the pad at x {pad[0]:.2f}, y {pad[1]:.2f}",
               f"put the vehicle within {_PLACE:g} m of the pad")  # fmt: skip


def _attitude_loop(model: Model, links: VehicleLinks) -> Check:
    """How roll and pitch are believed to follow commands, until the hover has measured it."""
    loop, mission = model.attitude_loop, model.scenario.mission
    measures = (
        "attitude" in mission.measures and mission.start == "hover" and links.config.pixhawk.setpoints == "attitude"
    )
    return row("attitude loop", loop.lag <= TESTED_LAG and loop.dead_time <= TESTED_DEAD_TIME,
               f"believed: lag {1e3 * loop.lag:.0f} ms, dead time {1e3 * loop.dead_time:.0f} ms; "
               + ("the hover measures it before contact" if measures else "not measured in this flight"),
               f"tune the autopilot's attitude loop: tested are {1e3 * TESTED_LAG:.0f} and {1e3 * TESTED_DEAD_TIME:.0f} ms",
               Verdict.WARNING)  # fmt: skip
