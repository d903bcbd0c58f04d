"""Every fault at random times of a mission: it ends on the ground, and only what must land in the doorway touches anything.

One time each; DOORMAN_FAULT_TIMES=20 in the environment for twenty. What became of each flight is in pytest's --junitxml.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from flight_rig import AUTOPILOT, SCENARIO, Flight, FlightRig, until

from doorman.exceptions import DoormanError, RecordingError
from doorman.flight import End
from doorman.hardware.emulators.servos_memory import WATCHDOG_ERROR
from doorman.hardware.emulators.servos_unit import ENCODER, OVERHEATING, OVERLOAD
from doorman.hardware.safety import Action
from doorman.ocp.solution import PlanStatus

TIMES = int(os.environ.get("DOORMAN_FAULT_TIMES", "1"))
LATEST = {"paper": 16.0, "push": 26.0}[SCENARIO]
"""After take-off; the missions take about 20 and 30 s."""
Injection = Callable[[FlightRig, Flight], object]


def put(path: str, value: object) -> Injection:
    """Set an attribute of the rig."""
    return lambda rig, _: rig.far.set(path, value)


def call(path: str, *arguments: object) -> Injection:
    return lambda rig, _: rig.far.call(path, *arguments)


def line(name: str, value: object) -> Injection:
    """A fault of the MAVLink line in both directions."""

    def inject(rig: FlightRig, _: Flight) -> None:
        for way in ("incoming", "outgoing"):
            rig.far.set(f"rig.autopilot.{way}.{name}", value)

    return inject


def fail(_: FlightRig, flight: Flight) -> None:
    def progress() -> None:
        raise DoormanError("made up")

    flight.on_progress = progress


def hang(seconds: float) -> Injection:
    def inject(_: FlightRig, flight: Flight) -> None:
        until_then = time.monotonic() + seconds
        flight.on_progress = lambda: time.sleep(max(0.0, until_then - time.monotonic()))

    return inject


def spoil_planner(what: str) -> Injection:
    """The planner raises an error, is slow, or finds nothing, from now on."""

    def inject(rig: FlightRig, flight: Flight) -> None:
        real = rig.planner.replan

        def replan(state, *arguments, **options):
            if what == "raises":
                raise DoormanError("made up by the planner")
            if what == "slow":
                time.sleep(0.15)
                return real(state, *arguments, **options)
            if what == "fails":
                return replace(real(state, *arguments, **options), status=PlanStatus.INFEASIBLE, violated="made up")
            return real(np.full_like(state, np.nan), *arguments, **options)

        rig.planner.replan = replan

    return inject


def swap_servo(rig: FlightRig, _: Flight) -> None:
    """A servo falls silent, and one of another model answers in its place."""
    rig.far.call("rig.servos.faults.silent.add", 1)
    time.sleep(0.5)
    rig.far.call("set_register", 1, "model number", 1060)
    rig.far.call("rig.servos.faults.silent.discard", 1)


def take_over(rig: FlightRig, _: Flight) -> None:
    """A pilot who turns the mode switch looks for a moment, pulls the vehicle straight out of the doorway, and lands it there."""
    rig.far.call("rig.autopilot.pilot_mode", "position")
    time.sleep(1.0)
    rig.far.call("rig.autopilot.pilot_sticks", (-0.5, 0.0, 0.0))
    until(lambda: rig.snapshot.truth.position[0] < rig.places.hover[0] + 0.1, "the pilot's way out")
    rig.far.call("rig.autopilot.pilot_sticks", (0.0, 0.0, 0.0))
    time.sleep(1.0)
    rig.far.call("rig.autopilot.pilot_mode", "land")


def fill_disk(_: FlightRig, flight: Flight) -> None:
    """Whatever the recorder writes from now on is refused, as by a disk without space."""
    stream = flight.recorder._stream
    assert stream is not None
    with Path("/dev/full").open("wb", buffering=0) as full:
        os.dup2(full.fileno(), stream.fileno())


FAULTS: dict[str, Injection] = {
    "mocap silent": put("rig.mocap.faults.silent", True),
    "mocap frozen": put("rig.mocap.faults.frozen", True),
    "mocap zeroed": put("rig.mocap.faults.zeroed", True),
    "mocap jumps": put("rig.mocap.faults.jump", (0.5, 0.3, 0.0)),
    "mocap late": put("rig.mocap.faults.delay", 0.3),
    "mocap loses half": put("rig.mocap.faults.loss", 0.5),
    "mocap without numbers": put("rig.mocap.faults.not_finite", True),
    "mocap outliers": put("rig.mocap.faults.outliers", 0.2),
    "link cut": line("cut", True),
    "link loses a third": line("loss", 0.3),
    "link duplicates": line("duplicate", 0.5),
    "link reorders": line("reorder", 0.3),
    "link corrupts": line("corrupt", 0.3),
    "heartbeats end": call("rig.autopilot.stop_heartbeats", True),
    "pilot takes over": take_over,
    "pilot stops the motors": call("rig.autopilot.kill_switch"),
    "autopilot reboots": call("rig.autopilot.reboot"),
    "autopilot loses its estimate": call("rig.autopilot.fail_estimator"),
    "autopilot's clock jumps": call("rig.autopilot.jump_clock", 30.0),
    "autopilot tells no numbers": call("rig.autopilot.confuse"),
    "battery silent": put("rig.autopilot.battery.silent", True),
    "battery low": put("rig.autopilot.battery.remaining", 0.17),
    "battery empty": put("rig.autopilot.battery.remaining", 0.05),
    "servo overloaded": call("set_register", 2, "hardware error status", OVERLOAD),
    "gripper overloaded": call("set_register", 5, "hardware error status", OVERLOAD),
    "servo without its encoder": call("set_register", 2, "hardware error status", ENCODER),
    "servo overheated": call("set_register", 3, "hardware error status", OVERHEATING),
    "servo hot": call("set_register", 3, "present temperature", 75),
    "servo of another model": swap_servo,
    "servo restarts": call("restart_servo", 2),
    "servo's watchdog fires": call("set_register", 2, "bus watchdog", WATCHDOG_ERROR),
    "servo missing": lambda rig, _: rig.far.call("rig.servos.faults.silent.add", 2),
    "servo bus noisy": put("rig.servos.faults.noise", 0.3),
    "servo bus corrupt": put("rig.servos.faults.corrupt", 0.5),
    "servos unplugged": call("rig.servos.unplug"),
    "mission raises": fail,
    "controller hangs": hang(4.0),
    "planner raises": spoil_planner("raises"),
    "planner slow": spoil_planner("slow"),
    "planner finds nothing": spoil_planner("fails"),
    "planner is given no numbers": spoil_planner("nan"),
    "somebody pushes": call("rig.plant.blow", (-12.0, 0.0, 0.0)),
    "door slammed": call("rig.plant.kick", 1.0),
    "door blocked": call("rig.plant.block", 40.0),
    "disk full": fill_disk,
    "operator gives up": lambda _, flight: flight.session.interrupt(),
    "process is asked to end": lambda _, flight: flight.session.terminate(),
}

if SCENARIO == "push":
    del FAULTS["gripper overloaded"]  # there is none

if AUTOPILOT == "ardupilot":  # what it knows of the lag of poses does not come back from that: no flight after it
    del FAULTS["autopilot's clock jumps"]

MOTORS_OFF_ALOFT = {"pilot stops the motors", "autopilot reboots"}
"""The vehicle falls where it is: it may touch the door."""
LANDED_THERE = {"autopilot loses its estimate"}
"""It comes down where it is and where it drifts to, as after LAND: it may touch door, frame or sill."""
STRUCK = {"door slammed": {"servo_4_0 and leaf"}}
"""A leaf that is thrown at the tip strikes what is next to the tip, too, before anything can be done about it."""

SPECIAL_ENDS = {
    "heartbeats end": {End.STILL_ARMED},  # nobody says that the motors have stopped
    "pilot stops the motors": {End.FALLEN},
    "autopilot reboots": {End.FALLEN},
}


@pytest.fixture(autouse=True)
def planner_as_it_was(rig: FlightRig):
    yield
    vars(rig.planner).pop("replan", None)


def down(rig: FlightRig) -> bool:
    """Whether it lies on the ground, or on the sill, with its motors off."""
    seen = rig.snapshot
    return not seen.motors and (seen.on_ground or float(np.linalg.norm(seen.truth.velocity)) < 0.02)


@pytest.mark.parametrize("repetition", range(TIMES))
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_at_any_time_ends_on_the_ground(
    rig: FlightRig, fault: str, repetition: int, record_property: Callable[[str, object], None], tmp_path: Path
) -> None:
    seed = np.frombuffer(fault.encode(), np.uint8).sum() + 1000 * repetition
    when = float(np.random.default_rng(seed).uniform(0.2, LATEST))
    flight = rig.flight(tmp_path / "flight.mcap").begin().until_phase("hover", "approach")
    began = time.monotonic()
    until(lambda: time.monotonic() - began > when or flight.session.phase == "done", "the time of the fault")
    phase, angle = flight.session.phase, float(rig.snapshot.truth.door_angle)
    at_the_door = phase not in ("hover", "approach", "done")
    FAULTS[fault](rig, flight)
    report = flight.end()
    said = (report.end, report.message, round(when, 2), flight.told())
    with pytest.raises(RecordingError, match="No space left") if fault == "disk full" else nullcontext():
        flight.recorder.close()
    allowed = {End.LANDED, End.TAKEN_OVER, End.UNHEARD} | SPECIAL_ENDS.get(fault, set())
    assert report.end in allowed, said
    assert report.completed or report.message, said
    until(lambda: down(rig), f"down, motors off: {said}")
    action = flight.session.supervisor.action
    for name, value in {"when": round(when, 2), "phase": phase, "door": round(np.degrees(angle), 1),
                        "action": action and action.name, "why": report.message, "end": report.end.name,
                        "touched": sorted(rig.collided), "place": rig.snapshot.truth.position.round(2).tolist(),
                        "findings": [finding.fault.name for finding in report.findings]}.items():  # fmt: skip
        record_property(name, value)
    there = fault in LANDED_THERE or (at_the_door and action is Action.LAND)
    if fault not in MOTORS_OFF_ALOFT and not there:
        assert set(rig.collided) <= STRUCK.get(fault, set()), said
