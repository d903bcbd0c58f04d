"""Faults of cameras, vehicle, servos and process at hover and in the doorway, with the end that the fault table promises."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from flight_ends import (
    Injection,
    anywhere,
    assert_at_the_pad,
    assert_before_the_door,
    assert_down,
    at_hover,
    call,
    found,
    lands,
    put,
    swinging,
)
from flight_rig import Flight, FlightRig, until

from doorman.flight import End
from doorman.hardware.pixhawk import Outcome, OutcomeStatus
from doorman.hardware.safety import Fault
from doorman.rig.emulated import SPRING
from doorman.rig.emulators.servos.unit import OVERLOAD


def terminate(_: FlightRig, flight: Flight) -> None:
    flight.session.terminate()


def give_up_and_terminate(_: FlightRig, flight: Flight) -> None:
    flight.session.interrupt()
    flight.session.terminate()


def lose_the_terminal(_: FlightRig, flight: Flight) -> None:
    """Whatever is told, nobody hears it, and every attempt fails."""

    def broken(words: str) -> None:
        raise BrokenPipeError(words)

    flight.session.flight._listener = broken
    flight.session.terminate()


def astray(*offset: float) -> Injection:
    """Poses put it right a second later: what it was told to hold until then is not where the vehicle is."""
    return put("rig.autopilot.estimator.error", np.array(offset))


@dataclass(frozen=True)
class Case:
    where: Callable[[FlightRig], Flight]
    inject: Injection
    shows: tuple[Fault, ...]
    place: Callable[[FlightRig], None] = assert_at_the_pad
    alone: bool = False
    """Whether nothing else may be found."""


CASES = {
    "cameras silent": Case(at_hover, put("rig.mocap.faults.silent", True), (Fault.POSE,), anywhere),
    "cameras frozen": Case(at_hover, put("rig.mocap.faults.frozen", True), (Fault.POSE,), anywhere),
    "cameras zeroed": Case(at_hover, put("rig.mocap.faults.zeroed", True), (Fault.POSE,), anywhere),
    "cameras frozen, gripping": Case(swinging, put("rig.mocap.faults.frozen", True), (Fault.POSE,), assert_before_the_door),
    "cameras jump, gripping": Case(swinging, put("rig.mocap.faults.jump", (0.3, -0.3, 0.0)), (Fault.POSE,),
                                   assert_before_the_door),
    "astray to the left": Case(swinging, astray(0.0, 0.6, 0.0), (Fault.DIVERGENCE,), assert_before_the_door, True),
    "astray to the right": Case(swinging, astray(0.0, -0.6, 0.0), (Fault.DIVERGENCE,), assert_before_the_door, True),
    "astray ahead": Case(swinging, astray(0.6, 0.0, 0.0), (Fault.DIVERGENCE,), assert_before_the_door, True),
    "battery low": Case(at_hover, put("rig.autopilot.battery.remaining", 0.17), (Fault.BATTERY_LOW,), alone=True),
    "battery empty": Case(at_hover, put("rig.autopilot.battery.remaining", 0.05), (Fault.BATTERY_CRITICAL,)),
    "battery empty, gripping": Case(swinging, put("rig.autopilot.battery.remaining", 0.05), (Fault.BATTERY_CRITICAL,)),
    "gripper fails": Case(swinging, call("set_register", 5, "hardware error status", OVERLOAD), (Fault.GRIPPER,)),
    "servo shuts down": Case(at_hover, call("set_register", 2, "hardware error status", OVERLOAD), (Fault.SERVOS_FAILED,)),
    "servos unplugged": Case(at_hover, call("rig.servos.unplug"), ()),
    "servos unplugged, gripping": Case(swinging, call("rig.servos.unplug"), (Fault.SERVOS_DISCONNECTED,)),
    "asked to end": Case(at_hover, terminate, (Fault.TERMINATED,), alone=True),
    "given up, then asked to end": Case(at_hover, give_up_and_terminate, (Fault.OPERATOR_ABORT, Fault.TERMINATED), alone=True),
    "terminal gone": Case(at_hover, lose_the_terminal, (Fault.TERMINATED,), alone=True),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_fault_in_flight(rig: FlightRig, name: str) -> None:
    case = CASES[name]
    flight = case.where(rig)
    case.inject(rig, flight)
    report = lands(rig, flight, case.place)
    assert found(report) >= set(case.shows) and not (case.alone and len(found(report)) > len(case.shows))
    assert Fault.SESSION not in found(report), "the program itself flew it back"


def test_wind_pushes_too_hard(rig):
    flight = at_hover(rig)
    rig.far.call("rig.plant.blow", (-25.0, 0.0, 0.0))
    until(lambda: flight.session.supervisor.findings, "a finding")
    rig.far.call("rig.plant.blow", (0.0, 0.0, 0.0))
    assert found(lands(rig, flight, anywhere)) & {Fault.FORCE, Fault.SPEED, Fault.TILT}


def test_a_gripper_that_is_stuck_for_a_while(rig):
    flight = swinging(rig)
    rig.far.call("set_spring", -3.0)
    flight.session.supervisor.report(Fault.SPEED)
    time.sleep(3.0)
    assert rig.links.holding
    rig.far.call("set_spring", SPRING)
    lands(rig, flight)


def test_a_gripper_that_is_stuck_as_the_mission_lets_go(rig):
    """The mission would draw at the door, and retreat with it in its hand."""
    flight = swinging(rig)
    rig.far.call("set_spring", -3.0)
    flight.session.interrupt()
    until(lambda: Fault.GRIPPER in {one.fault for one in flight.session.supervisor.findings}, "a gripper that is stuck")
    time.sleep(2.0)
    assert rig.links.holding
    rig.far.call("set_spring", SPRING)
    assert found(lands(rig, flight)) == {Fault.OPERATOR_ABORT, Fault.GRIPPER}


@pytest.mark.parametrize(
    ("inject", "words"),
    [
        (call("set_spring", 0.0), "stronger spring"),
        (put("rig.autopilot.brain.refusal", "Preflight Fail: made up"), "arm"),
    ],
    ids=["weak spring", "arming refused"],
)
def test_what_is_refused_on_the_ground_is_not_flown(rig, inject, words):
    flight = rig.flight()
    inject(rig, flight)
    report = flight.begin().end()
    assert report.end is End.NOT_FLOWN and words in report.message
    assert not rig.snapshot.motors


def test_a_vehicle_that_does_not_take_off_is_not_flown_back(rig, monkeypatch):
    monkeypatch.setattr(rig.links.autopilot, "take_off", lambda height: Outcome(OutcomeStatus.REFUSED, "made up"))
    before = rig.snapshot.truth.position.copy()
    flight = rig.flight().begin()
    report = flight.end()
    assert (report.end, report.message) == (End.LANDED, "take off: refused: made up")
    assert not any("back" in words for words in flight.said)
    assert rig.snapshot.truth.position == pytest.approx(before, abs=0.05)
    assert_down(rig)


def test_somebody_arms_it_after_the_checklist(rig):
    autopilot = rig.links.autopilot
    assert autopilot.engage().done and autopilot.arm().done
    report = rig.flight().begin().end()
    assert report.message == "arm: somebody has armed the vehicle"
    assert not rig.snapshot.motors, "it stands, and is ours"


def test_autopilot_reboots(rig):
    flight = at_hover(rig)
    rig.far.call("rig.autopilot.reboot")
    report = flight.end()
    assert report.end in (End.FALLEN, End.TAKEN_OVER)
    assert report.message, "whoever sees it first says so"
    until(lambda: rig.snapshot.on_ground, "on the ground")
