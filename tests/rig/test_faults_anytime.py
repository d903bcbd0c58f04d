"""Every fault at random times of a mission: it shows as promised, ends on the ground, and touches nothing but where it must land.

One time each; DOORMAN_FAULT_TIMES=20 in the environment for twenty.
"""

from __future__ import annotations

import os
import time
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from flight_ends import Injection, call, put
from flight_rig import AUTOPILOT, SCENARIO, Flight, FlightRig, until

from doorman.exceptions import DoormanError, RecordingError
from doorman.flight import End, FlightReport
from doorman.hardware.safety import Action, Fault
from doorman.ocp.solvers.solution import PlanStatus
from doorman.rig.emulators.servos.table import WATCHDOG_ERROR
from doorman.rig.emulators.servos.unit import ENCODER, OVERHEATING, OVERLOAD

TIMES = int(os.environ.get("DOORMAN_FAULT_TIMES", "1"))
LATEST = {"paper": 16.0, "push": 26.0}[SCENARIO]
"""After take-off; the missions take about 20 and 30 s."""


def line(name: str, value: object) -> Injection:
    """A fault of the MAVLink line in both directions."""

    def inject(rig: FlightRig, _: Flight) -> None:
        for way in ("incoming", "outgoing"):
            rig.far.set(f"rig.autopilot.{way}.{name}", value)

    return inject


def jump_clock(rig: FlightRig, _: Flight) -> None:
    jumped = "rig.autopilot.clock.jumped"
    rig.far.set(jumped, rig.far.get(jumped) + 30.0)


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
    rig.far.set("rig.autopilot.brain.sticks", (-0.5, 0.0, 0.0))
    until(lambda: rig.snapshot.truth.position[0] < rig.places.hover[0] + 0.1, "the pilot's way out")
    rig.far.set("rig.autopilot.brain.sticks", (0.0, 0.0, 0.0))
    time.sleep(1.0)
    rig.far.call("rig.autopilot.pilot_mode", "land")


def fill_disk(_: FlightRig, flight: Flight) -> None:
    """Whatever the recorder writes from now on is refused, as by a disk without space."""
    stream = flight.recorder._stream
    assert stream is not None
    with Path("/dev/full").open("wb", buffering=0) as full:
        os.dup2(full.fileno(), stream.fileno())


@dataclass(frozen=True)
class Row:
    """A fault, and what the fault table promises of it."""

    inject: Injection
    shows: Fault | str | tuple[Fault | str, ...] = ()
    """What is found first, or with which words the mission gives up where nothing is; nothing: it goes on to its end."""
    then: tuple[Fault, ...] = ()
    """What may be found besides."""
    late: bool = False
    """It may show only after the flight, or do nothing where the door has been opened."""

    def judge(self, report: FlightReport, leaving: bool) -> str:
        """What is not as promised, where the door was being left already, or not; empty if all is."""
        shows = self.shows if isinstance(self.shows, tuple) else (self.shows,)
        found = [finding.fault for finding in report.findings]
        if not found and report.completed:
            return "it had no consequence" if shows and not (leaving or self.late) else ""
        if unexpected := set(found) - set(shows) - set(self.then):
            return f"found, too: {unexpected}"
        if found:
            return "" if found[0] in shows else "found in another order"
        given_up = any(one in report.message for one in shows if isinstance(one, str))
        return "" if given_up else "given up for another reason"


UNHEARD = Fault.TELEMETRY, Fault.TELEMETRY_GRIPPING
THROWN = Fault.SPEED, Fault.TILT, Fault.FENCE, Fault.FORCE, Fault.THRUST, Fault.DIVERGENCE, Fault.POSE, Fault.STATE
STILL = (Fault.SERVOS_STOPPED,)
SERVO_GONE = "the servos' angles are too old"

FAULTS = {
    "mocap silent": Row(put("rig.mocap.faults.silent", True), Fault.POSE),
    "mocap frozen": Row(put("rig.mocap.faults.frozen", True), Fault.POSE),
    "mocap zeroed": Row(put("rig.mocap.faults.zeroed", True), Fault.POSE),
    "mocap jumps": Row(put("rig.mocap.faults.jump", (0.5, 0.3, 0.0)), Fault.POSE_JUMPED, (Fault.POSE, Fault.DIVERGENCE)),
    "mocap late": Row(put("rig.mocap.faults.delay", 0.3), Fault.POSE_LATE, (Fault.POSE, Fault.DIVERGENCE)),
    "mocap loses half": Row(put("rig.mocap.faults.loss", 0.5)),
    "mocap without numbers": Row(put("rig.mocap.faults.not_finite", True), Fault.POSE),
    "mocap outliers": Row(put("rig.mocap.faults.outliers", 0.2)),
    "link cut": Row(line("cut", True), UNHEARD, (Fault.LINK, Fault.THRUST, Fault.SPEED)),
    "link loses a third": Row(line("loss", 0.3)),
    "link duplicates": Row(line("duplicate", 0.5)),
    "link reorders": Row(line("reorder", 0.3)),
    "link corrupts": Row(line("corrupt", 0.3)),
    "heartbeats end": Row(put("rig.autopilot.telemetry.heartbeats_stopped", True), Fault.HEARTBEAT,
                          (Fault.SESSION_SILENT, Fault.SESSION)),
    "pilot takes over": Row(take_over, Fault.PILOT),
    "pilot stops the motors": Row(call("rig.autopilot.kill_switch"), Fault.PILOT, THROWN),
    "autopilot reboots": Row(call("rig.autopilot.reboot"), ("does not control", Fault.POSE, Fault.PILOT, Fault.SPEED)),
    "autopilot loses its estimate": Row(put("rig.autopilot.estimator.failed", True), Fault.PILOT),
    "autopilot's clock jumps": Row(jump_clock),
    "autopilot tells no numbers": Row(put("rig.autopilot.telemetry.confused", True), UNHEARD),
    "battery silent": Row(put("rig.autopilot.battery.silent", True), Fault.BATTERY_SILENT, late=True),
    "battery low": Row(put("rig.autopilot.battery.remaining", 0.17), Fault.BATTERY_LOW),
    "battery empty": Row(put("rig.autopilot.battery.remaining", 0.05), (Fault.BATTERY_CRITICAL, Fault.BATTERY_LOW)),
    "servo overloaded": Row(call("set_register", 2, "hardware error status", OVERLOAD), Fault.SERVOS_FAILED, STILL),
    "gripper overloaded": Row(call("set_register", 5, "hardware error status", OVERLOAD),
                              (Fault.GRIPPER, Fault.SERVOS_FAILED), STILL),
    "servo without its encoder": Row(call("set_register", 2, "hardware error status", ENCODER), Fault.SERVOS_FAILED, STILL),
    "servo overheated": Row(call("set_register", 3, "hardware error status", OVERHEATING), Fault.SERVOS_FAILED, STILL),
    "servo hot": Row(call("set_register", 3, "present temperature", 75), Fault.SERVOS_STOPPED),
    "servo of another model": Row(swap_servo, Fault.SERVOS_FAILED, STILL),
    "servo restarts": Row(call("restart_servo", 2), Fault.SERVOS_FAILED, STILL),
    "servo's watchdog fires": Row(call("set_register", 2, "bus watchdog", WATCHDOG_ERROR)),
    "servo missing": Row(lambda rig, _: rig.far.call("rig.servos.faults.silent.add", 2), SERVO_GONE, STILL),
    "servo bus noisy": Row(put("rig.servos.faults.noise", 0.3)),
    "servo bus corrupt": Row(put("rig.servos.faults.corrupt", 0.5), SERVO_GONE),
    "servos unplugged": Row(call("rig.servos.unplug"), Fault.SERVOS_DISCONNECTED),
    "mission raises": Row(fail, "made up"),
    "controller hangs": Row(hang(4.0), Fault.CONTROLLER),
    "planner raises": Row(spoil_planner("raises"), "made up by the planner"),
    "planner slow": Row(spoil_planner("slow")),
    "planner finds nothing": Row(spoil_planner("fails"), "does not move on", late=True),
    "planner is given no numbers": Row(spoil_planner("nan"), "not finite"),
    "somebody pushes": Row(call("rig.plant.blow", (-12.0, 0.0, 0.0)), THROWN, (Fault.CONTROLLER,), late=True),
    "door slammed": Row(call("rig.plant.kick", 1.0), "the door is slammed", late=True),
    "door blocked": Row(call("rig.plant.block", 40.0), ("the door", "a jamb", "the leaf"), late=True),
    "disk full": Row(fill_disk),
    "operator gives up": Row(lambda _, flight: flight.session.interrupt(), (Fault.OPERATOR_ABORT, Fault.OPERATOR_LAND)),
    "process is asked to end": Row(lambda _, flight: flight.session.terminate(), Fault.TERMINATED),
}  # fmt: skip

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
def test_a_fault_at_any_time_ends_on_the_ground(rig: FlightRig, fault: str, repetition: int, tmp_path: Path) -> None:
    seed = np.frombuffer(fault.encode(), np.uint8).sum() + 1000 * repetition
    when = float(np.random.default_rng(seed).uniform(0.2, LATEST))
    flight = rig.flight(tmp_path / "flight.mcap").begin().until_phase("hover", "approach")
    began = time.monotonic()
    until(lambda: time.monotonic() - began > when or flight.session.phase == "done", "the time of the fault")
    phase = flight.session.phase
    at_the_door, leaving = phase not in ("hover", "approach", "done"), phase in ("release", "retreat", "done")
    FAULTS[fault].inject(rig, flight)
    report = flight.end()
    said = (report.end, report.message, round(when, 2), phase, flight.told())
    with pytest.raises(RecordingError, match="No space left") if fault == "disk full" else nullcontext():
        flight.recorder.close()
    allowed = {End.LANDED, End.TAKEN_OVER, End.UNHEARD} | SPECIAL_ENDS.get(fault, set())
    action = flight.session.supervisor.action
    there = fault in LANDED_THERE or (at_the_door and action is Action.LAND)
    if there:
        allowed |= {End.ON_SILL, End.HELD_UP, End.CRASHED}
    assert report.end in allowed, said
    assert report.completed or report.message, said
    until(lambda: down(rig), f"down, motors off: {said}")
    wrong = FAULTS[fault].judge(report, leaving)
    assert not wrong, (wrong, said)
    if fault not in MOTORS_OFF_ALOFT and not there:
        assert set(rig.collided) <= STRUCK.get(fault, set()), said
