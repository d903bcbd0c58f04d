"""Dry run: what can be learnt of a vehicle and a scenario without sending a single byte."""

from __future__ import annotations

import contextlib
import os
import stat
import time
from collections.abc import Container, Iterator
from dataclasses import replace
from pathlib import Path

from doorman.exceptions import BackendError
from doorman.feasibility import Report
from doorman.flight.ground.judgements import Check, Verdict, judge_battery, judge_limits, judge_scenario, row
from doorman.hardware.mocap import MocapReceiver
from doorman.hardware.pixhawk import Autopilot
from doorman.hardware.vehicle import VehicleConfig
from doorman.model import Model

_LATER = "the checklist of a flight checks them"


def listen(model: Model, config: VehicleConfig, findings: Report) -> list[Check]:
    """Listen to the links and go through what can be checked so; nothing is sent on any of them.

    Args:
        model: Model of the scenario.
        config: Of the links, which are opened and closed here.
        findings: Of `doorman.feasibility.check` for the scenario.

    Returns:
        All rows; what only an answer could tell is a warning.
    """
    rows = [*_autopilot(model, config), *_mocap(config), *_servos(config)]
    return [*rows, *judge_limits(model), *judge_scenario(findings)]


NEEDED = {
    "pixhawk.connection": ("autopilot", "--pixhawk udp:14540"),
    "servos.port": ("servos", "--servos /dev/ttyUSB0"),
}
"""Links that every flight needs: row and option, by key."""


def without_links(model: Model, findings: Report, named: Container[str]) -> list[Check]:
    """What a flight needs, where only some keys of its links are named; nothing is opened. A link that is missing is a no."""
    vehicle, grips = model.vehicle, model.scenario.contact.kind == "grip"
    joints = ", ".join(vehicle.joint_names)
    needs = {
        "autopilot": f"PX4 or ArduPilot, {len(vehicle.rotors)} rotors, {vehicle.mass:.2f} kg",
        "servos": f"{vehicle.n_arm} Dynamixel servos, {joints}{', and one for the gripper' if grips else ''}",
    }
    rows = [
        Check(name, Verdict.WARNING if key in named else Verdict.BAD, f"needs {needs[name]}",
              "not opened" if key in named else f"{option}, or a vehicle file: doorman vehicle new my.toml")
        for key, (name, option) in NEEDED.items()
    ]  # fmt: skip
    poses = Check(
        "mocap", Verdict.WARNING, "needs poses of the vehicle", "--mocap udp:51001, or the autopilot's own estimate"
    )
    return [*rows, poses, *judge_limits(model), *judge_scenario(findings)]


def _autopilot(model: Model, config: VehicleConfig) -> Iterator[Check]:
    autopilot = Autopilot(replace(config.pixhawk, listen_only=True))
    try:
        autopilot.open()
    except BackendError as error:
        yield Check("autopilot", Verdict.BAD, str(error),
                    "a dry run sends nothing: on udpout and tcp the autopilot waits for a first message")  # fmt: skip
        return
    try:
        time.sleep(config.pixhawk.timeouts.heartbeat)
        state, status = autopilot.state(), autopilot.status()
    finally:
        autopilot.stop()
    rates = ", ".join(f"{name} {rate:.0f}/s" for name, rate in status.rates.items() if rate > 0.0)
    yield Check("autopilot", Verdict.GOOD, f"{status.dialect}, {state.mode}, receives nothing from doorman; {rates}")
    found = "armed" if state.armed else "disarmed"
    yield row("disarmed", not state.armed, found, "land and disarm the vehicle first")
    yield judge_battery(state.battery, status.conditions, model.scenario.safety.low_battery)
    yield Check("clock, rates, parameters", Verdict.WARNING, "not checked in a dry run", _LATER)


def _mocap(config: VehicleConfig) -> Iterator[Check]:
    if config.mocap is None:
        yield Check("mocap", Verdict.WARNING, "none: the flight uses the autopilot's own estimate")
        return
    receiver = MocapReceiver(config.mocap)
    try:
        with receiver:
            time.sleep(config.pixhawk.timeouts.heartbeat)
            pose, rate = receiver.read(), receiver.statistics.frame_rate
    except BackendError as error:
        yield Check("mocap", Verdict.BAD, str(error), "see docs/hardware/mocap.md")
        return
    found = f"pose {pose.quality.value}, {rate:.1f} frames/s"
    yield row("mocap", pose.fresh, found, "make sure that the cameras see the object")


def _servos(config: VehicleConfig) -> Iterator[Check]:
    if not config.servos.n:
        return
    device = config.servos.port
    there = False
    with contextlib.suppress(OSError):
        there = stat.S_ISCHR(Path(device).stat().st_mode) and os.access(device, os.R_OK | os.W_OK)
    if there:
        yield Check("servos", Verdict.WARNING, f"{device} exists; its servos are not checked in a dry run", _LATER)
    else:
        yield Check("servos", Verdict.BAD, f"{device} does not exist, or this user may not read and write it",
                    "see docs/hardware/servos.md")  # fmt: skip
