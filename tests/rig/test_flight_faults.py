"""Rows of the fault table, flown: a fault at hover or on the way to the door, and the end that the table promises."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from flight_rig import AUTOPILOT, Flight, FlightRig, until

from doorman.exceptions import DoormanError
from doorman.flight import End, FlightReport, way_back
from doorman.hardware.emulators.servos_unit import OVERLOAD
from doorman.hardware.pixhawk import Authority, EventKind, Outcome, OutcomeStatus
from doorman.hardware.safety import Action, Fault
from doorman.hardware.safety import supervisor as supervisor_module
from doorman.rig.emulated import SPRING


def at_hover(rig: FlightRig) -> Flight:
    return rig.flight().begin().until_phase("hover", "approach")


def found(report: FlightReport) -> set[Fault]:
    return {finding.fault for finding in report.findings}


def assert_down(rig: FlightRig) -> None:
    """On the ground, upright, motors off, and nothing was touched."""
    until(lambda: not rig.snapshot.motors and rig.snapshot.on_ground, "on the ground, motors off")
    truth = rig.snapshot.truth
    assert np.abs(truth.attitude[:2]).max() < 0.1
    assert not rig.collided


def assert_at_the_pad(rig: FlightRig) -> None:
    away = rig.snapshot.truth.position[:2] - rig.places.pad[:2]
    assert np.linalg.norm(away) < 0.3


def lands_on_the_pad(rig: FlightRig, flight: Flight) -> FlightReport:
    """The flight to its end, which is on the pad."""
    report = flight.end()
    assert report.end is End.LANDED
    assert_down(rig)
    assert_at_the_pad(rig)
    return report


def give_up_and_hover(flight: Flight) -> None:
    flight.session.interrupt()
    until(lambda: any(words.startswith("hover: ") for words in flight.said), "a hover after the retreat", flight.told)


def test_operator_gives_up(rig, monkeypatch):
    monkeypatch.setattr(way_back, "OPERATOR_PATIENCE", 4.0)
    flight = at_hover(rig)
    give_up_and_hover(flight)
    time.sleep(3.0)
    assert np.linalg.norm(rig.snapshot.truth.position - rig.places.hover) < 0.3
    assert np.linalg.norm(rig.snapshot.truth.velocity) < 0.2
    report = flight.end()
    assert (report.end, report.completed) == (End.LANDED, False)
    assert found(report) == {Fault.OPERATOR_ABORT}
    assert "retreat" in flight.recording["mission"]["state"], "the mission's own controller flew back"
    assert_down(rig)
    assert_at_the_pad(rig)


def test_operator_lands_out_of_the_hover_after_giving_up(rig):
    flight = at_hover(rig)
    give_up_and_hover(flight)
    flight.session.interrupt()
    began = time.monotonic()
    assert Fault.OPERATOR_LAND in found(flight.end())
    assert time.monotonic() - began < 0.7 * way_back.OPERATOR_PATIENCE
    assert_down(rig)
    assert_at_the_pad(rig)


def test_operator_lands(rig):
    flight = at_hover(rig)
    flight.session.interrupt()
    flight.session.interrupt()  # the same, by its group and by its parent
    time.sleep(0.3)
    assert flight.session.supervisor.action is Action.ABORT
    flight.session.interrupt()
    report = flight.end()
    assert report.end is End.LANDED
    assert Fault.OPERATOR_LAND in found(report)
    assert_down(rig)


def test_process_is_asked_to_end(rig):
    flight = at_hover(rig)
    flight.session.terminate()
    report = lands_on_the_pad(rig, flight)
    assert found(report) == {Fault.TERMINATED}


def test_process_is_asked_to_end_while_it_rises(rig):
    flight = rig.flight().begin()
    until(lambda: rig.snapshot.truth.position[2] > 0.5, "a vehicle that rises", flight.told)
    flight.session.terminate()
    until(lambda: flight.session.supervisor.action is Action.LAND, "its way has not begun")
    assert flight.end().end is End.LANDED
    assert_down(rig)


def test_process_is_asked_to_end_after_the_operator_gave_up(rig):
    flight = at_hover(rig)
    flight.session.interrupt()
    flight.session.terminate()
    report = lands_on_the_pad(rig, flight)
    assert found(report) == {Fault.OPERATOR_ABORT, Fault.TERMINATED}


def test_process_is_asked_to_end_again(rig):
    flight = at_hover(rig)
    flight.session.terminate()
    flight.session.terminate()
    time.sleep(1.2)
    assert flight.session.supervisor.action is Action.RETREAT, "the same signal, by group and parent"
    flight.session.terminate()
    report = flight.end()
    assert report.end is End.LANDED
    assert found(report) == {Fault.TERMINATED, Fault.OPERATOR_LAND}
    assert_down(rig)


@pytest.mark.parametrize("fault", ["silent", "frozen", "zeroed"])
def test_cameras_lose_the_vehicle(rig, fault):
    flight = at_hover(rig)
    rig.far.set(f"rig.mocap.faults.{fault}", True)
    report = flight.end()
    assert report.end is End.LANDED
    assert Fault.POSE in found(report)
    assert Fault.SESSION not in found(report), "the program itself flew it back"
    assert_down(rig)


def test_a_terminal_that_is_gone(rig):
    """Whatever is told, nobody hears it, and every attempt fails."""
    flight = at_hover(rig)

    def broken(words: str) -> None:
        raise BrokenPipeError(words)

    flight.session.flight._listener = broken
    flight.session.terminate()
    assert found(lands_on_the_pad(rig, flight)) == {Fault.TERMINATED}


def test_the_way_back_fails(rig, monkeypatch):
    """It lands where it is then, with the cameras' poses until it has."""
    flight = at_hover(rig)

    def broken() -> None:
        raise RuntimeError("made up")

    monkeypatch.setattr(flight.session.flight.way_back, "fly", broken)
    flight.session.terminate()
    report = flight.end()
    assert report.end is End.LANDED
    assert found(report) == {Fault.TERMINATED, Fault.SESSION}
    assert any("made up" in words for words in flight.said)
    assert_down(rig)


def swinging(rig: FlightRig) -> Flight:
    """In the doorway, with the door in the gripper."""
    flight = at_hover(rig).until_phase("open")
    until(lambda: np.degrees(rig.snapshot.truth.door_angle) < 60.0, "a door that swings")
    return flight


def assert_before_the_door(rig: FlightRig) -> None:
    disc = rig.model.vehicle.radius
    assert rig.snapshot.truth.position[0] < rig.model.door.hinge_position[0] - disc - 0.1, "out of the doorway"


def test_cameras_lose_a_vehicle_that_grips(rig):
    flight = swinging(rig)
    rig.far.set("rig.mocap.faults.frozen", True)
    report = flight.end()
    assert report.end is End.LANDED, "with its gripper closed it would hang on the door"
    assert Fault.POSE in found(report)
    assert Fault.SESSION not in found(report), "the program itself flew it back"
    assert_down(rig)
    assert_before_the_door(rig)


def test_cameras_find_it_elsewhere(rig):
    """Its autopilot must not be dragged along, and nothing may land in the doorway."""
    flight = swinging(rig)
    rig.far.set("rig.mocap.faults.jump", (0.3, -0.3, 0.0))
    report = flight.end()
    assert report.end is End.LANDED
    assert Fault.POSE in found(report)
    assert Fault.SESSION not in found(report), "the program itself flew it back"
    assert_down(rig)
    assert_before_the_door(rig)


@pytest.mark.parametrize("offset", [(0.0, 0.6, 0.0), (0.0, -0.6, 0.0), (0.6, 0.0, 0.0)])
def test_an_autopilot_that_goes_astray(rig, offset):
    """Poses put it right a second later: what it was told to hold until then is not where the vehicle is."""
    flight = swinging(rig)
    rig.far.call("rig.autopilot.lead_astray", offset)
    report = flight.end()
    assert report.end is End.LANDED
    assert found(report) == {Fault.DIVERGENCE}
    assert_down(rig)
    assert_before_the_door(rig)


def test_controller_hangs_in_the_doorway(rig):
    """For longer than the supervisor waits: it flies the vehicle out by itself."""
    flight = swinging(rig)
    let_go = threading.Event()
    flight.on_progress = lambda: (let_go.wait(30.0), None)[1]
    until(lambda: flight.session.supervisor.action is Action.LAND, "the supervisor has flown it out, and lands")
    assert_before_the_door(rig)
    let_go.set()
    report = flight.end()
    assert report.end is End.LANDED
    assert {Fault.CONTROLLER, Fault.SESSION} <= found(report)
    assert_down(rig)


def test_gripper_fails_while_it_grips(rig):
    flight = swinging(rig)
    rig.far.call("set_register", rig.model.n_arm + 1, "hardware error status", OVERLOAD)
    assert Fault.GRIPPER in found(lands_on_the_pad(rig, flight))


def test_pilot_takes_over(rig):
    flight = at_hover(rig)
    rig.far.call("rig.autopilot.pilot_mode", "position")
    until(lambda: rig.links.autopilot.status().authority is Authority.LOST, "the takeover")
    time.sleep(3.0)
    assert rig.links.mocap.read().fresh, "without poses the pilot could not hold a position"
    assert rig.snapshot.motors
    rig.far.call("rig.autopilot.pilot_mode", "land")
    report = flight.end()
    assert report.end is End.LANDED
    assert found(report) <= {Fault.PILOT}, "or the backend saw it first"
    assert_down(rig)


@contextmanager
def link_cut(rig: FlightRig) -> Iterator[None]:
    """Neither side of the MAVLink line hears the other meanwhile."""
    lines = ("rig.autopilot.outgoing.cut", "rig.autopilot.incoming.cut")
    for line in lines:
        rig.far.set(line, True)
    try:
        yield
    finally:
        for line in lines:
            rig.far.set(line, False)


def test_link_cut(rig):
    flight = at_hover(rig)
    with link_cut(rig):
        report = flight.end()
        assert report.end is End.UNHEARD
        assert Fault.LINK in found(report)
        assert_down(rig)  # by the autopilot's own failsafe


def test_link_cut_on_the_ground(rig):
    """A vehicle that was never told to arm has not flown, and nobody waits for its landing."""
    with link_cut(rig):
        until(lambda: EventKind.LINK_LOST in rig.links.autopilot.status().conditions, "a lost link")
        began = time.monotonic()
        report = rig.flight().begin().end()
        assert time.monotonic() - began < 20.0
    assert report.end is End.NOT_FLOWN
    assert "engage" in report.message


@pytest.mark.parametrize("angle", [60.0, 24.0])
def test_link_cut_while_it_grips(rig, angle):
    """The autopilot's failsafe flies away meanwhile: the door must be let go of before it pulls."""
    flight = swinging(rig)
    until(lambda: np.degrees(rig.snapshot.truth.door_angle) < angle, "the angle")
    with link_cut(rig):
        report = flight.end()
        assert report.end is End.UNHEARD
        assert Fault.TELEMETRY_GRIPPING in found(report)
        until(lambda: not rig.snapshot.motors, "landed by the autopilot's failsafe")
        assert not rig.collided
        assert_before_the_door(rig)


@pytest.mark.parametrize("longer", [1.0, 4.0])
def test_telemetry_is_silent_for_a_while(rig, longer):
    flight = swinging(rig)
    rig.far.set("rig.autopilot.outgoing.cut", True)
    until(lambda: flight.session.supervisor.findings, "a finding")
    time.sleep(longer)
    rig.far.set("rig.autopilot.outgoing.cut", False)
    report = flight.end()
    assert report.end is End.LANDED
    assert Fault.TELEMETRY_GRIPPING in found(report), "the door is let go of first"
    assert found(report) <= {Fault.TELEMETRY, Fault.TELEMETRY_GRIPPING}, "it gives up, flown by what the cameras see"
    assert_down(rig)
    assert_at_the_pad(rig)


def test_telemetry_is_silent_for_a_moment(rig):
    flight = swinging(rig)
    rig.far.set("rig.autopilot.outgoing.cut", True)
    time.sleep(0.7)
    rig.far.set("rig.autopilot.outgoing.cut", False)
    report = flight.end()
    assert report.end is End.LANDED
    assert report.completed and not report.findings, "the mission goes on meanwhile"
    assert_at_the_pad(rig)


def test_telemetry_stays_late(rig):
    """Heartbeats come, no state is fresh any more: the vehicle must not come down onto the sill."""
    flight = swinging(rig)
    rig.far.set("rig.autopilot.outgoing.delay", 0.8)
    report = flight.end()
    assert report.end is End.LANDED
    assert Fault.TELEMETRY in found(report)
    assert Action.LAND not in {finding.action for finding in report.findings}
    assert_down(rig)
    assert_before_the_door(rig)


def test_telemetry_has_gaps_on_the_way_back_without_cameras(rig):
    """It flies on in every gap, without knowing its place: dead reckoning does not wait."""
    flight = swinging(rig)
    rig.far.set("rig.mocap.faults.silent", True)
    until(lambda: flight.session.supervisor.action is Action.RETREAT, "a retreat", flight.told)
    while rig.links.engaged:
        rig.far.set("rig.autopilot.outgoing.cut", True)
        time.sleep(0.45)
        rig.far.set("rig.autopilot.outgoing.cut", False)
        time.sleep(0.05)
    report = flight.end()
    assert report.end is End.LANDED
    assert_down(rig)
    assert_before_the_door(rig)


def test_neither_heard_nor_seen_in_the_middle_of_the_way_back(rig):
    """It flies on: in a hover it would drift onto a jamb."""
    flight = swinging(rig)
    begin = rig.snapshot.truth.position[0]
    flight.session.terminate()
    until(lambda: rig.snapshot.truth.position[0] < begin - 0.3, "on its way", flight.told)
    rig.far.set("rig.mocap.faults.silent", True)
    rig.far.set("rig.autopilot.outgoing.delay", 0.8)
    until(lambda: EventKind.STATE_STALE in rig.links.autopilot.status().conditions, "an old state", flight.told)
    deepest = rig.snapshot.truth.position[0]
    while rig.links.engaged:
        assert rig.snapshot.truth.position[0] < deepest + 0.05
        time.sleep(0.02)
    report = flight.end()
    assert report.end is End.LANDED
    assert_down(rig)
    assert_before_the_door(rig)


def test_battery_low(rig):
    flight = at_hover(rig)
    rig.far.set("rig.autopilot.battery.remaining", 0.17)
    report = flight.end()
    assert report.end is End.LANDED
    assert found(report) == {Fault.BATTERY_LOW}
    assert_down(rig)
    assert_at_the_pad(rig)


@pytest.mark.parametrize("where", [at_hover, swinging])
def test_battery_nearly_empty(rig, where):
    flight = where(rig)
    rig.far.set("rig.autopilot.battery.remaining", 0.05)
    report = flight.end()
    assert report.end is End.LANDED
    assert Fault.BATTERY_CRITICAL in found(report)
    assert_down(rig)
    assert_at_the_pad(rig)


def test_servo_shuts_down(rig):
    flight = at_hover(rig)
    rig.far.call("set_register", 2, "hardware error status", OVERLOAD)
    assert Fault.SERVOS_FAILED in found(lands_on_the_pad(rig, flight))


def test_servos_unplugged(rig):
    flight = at_hover(rig)
    rig.far.call("rig.servos.unplug")
    lands_on_the_pad(rig, flight)


def test_servos_unplugged_while_it_grips(rig):
    flight = swinging(rig)
    rig.far.call("rig.servos.unplug")
    assert Fault.SERVOS_DISCONNECTED in found(lands_on_the_pad(rig, flight))


def test_a_gripper_that_is_stuck_for_a_while(rig):
    flight = swinging(rig)
    rig.far.call("set_spring", -3.0)
    flight.session.supervisor.report(Fault.SPEED)
    time.sleep(3.0)
    assert rig.links.holding
    rig.far.call("set_spring", SPRING)
    lands_on_the_pad(rig, flight)


def test_a_gripper_that_is_stuck_as_the_mission_lets_go(rig):
    """The mission would draw at the door, and retreat with it in its hand."""
    flight = swinging(rig)
    rig.far.call("set_spring", -3.0)
    flight.session.interrupt()
    until(lambda: Fault.GRIPPER in {one.fault for one in flight.session.supervisor.findings}, "a gripper that is stuck")
    time.sleep(2.0)
    assert rig.links.holding
    rig.far.call("set_spring", SPRING)
    report = lands_on_the_pad(rig, flight)
    assert found(report) == {Fault.OPERATOR_ABORT, Fault.GRIPPER}
    assert not rig.collided


def test_a_gripper_that_does_not_open_by_itself_is_not_flown(rig):
    rig.far.call("set_spring", 0.0)
    report = rig.flight().begin().end()
    rig.far.call("set_spring", SPRING)
    assert report.end is End.NOT_FLOWN
    assert "stronger spring" in report.message


def test_wind_pushes_too_hard(rig):
    flight = at_hover(rig)
    rig.far.call("rig.plant.blow", (-25.0, 0.0, 0.0))
    until(lambda: flight.session.supervisor.findings, "a finding")
    rig.far.call("rig.plant.blow", (0.0, 0.0, 0.0))
    report = flight.end()
    assert report.end is End.LANDED
    assert found(report) & {Fault.FORCE, Fault.SPEED, Fault.TILT}
    assert_down(rig)


@pytest.mark.parametrize("error", [DoormanError("made up"), RuntimeError("made up")])
def test_mission_raises_an_error(rig, error):
    flight = rig.flight()

    def fail() -> None:
        raise error

    flight.on_progress = fail
    report = flight.begin().end()
    message = "made up" if isinstance(error, DoormanError) else "RuntimeError: made up"
    assert (report.end, report.completed, report.message) == (End.LANDED, False, message)
    assert_down(rig)
    assert_at_the_pad(rig)


def test_controller_hangs(rig):
    flight = rig.flight()
    hung_until: list[float] = []

    def hang() -> None:
        if not hung_until:
            hung_until.append(time.monotonic() + 4.0)
            time.sleep(4.0)

    flight.on_progress = hang
    report = flight.begin().end()
    assert report.end is End.LANDED
    (finding,) = [one for one in report.findings if one.fault is Fault.CONTROLLER]
    assert finding.time < hung_until[0], "landed while it hung"
    assert_down(rig)


def test_supervisor_hangs(rig):
    flight = at_hover(rig)
    real = flight.session.supervisor._look

    def hang():
        time.sleep(3.0)
        return real()

    flight.session.supervisor._look = hang
    report = flight.end()
    assert report.end is End.LANDED
    assert "supervisor is silent" in report.message
    assert_down(rig)


def test_arming_refused(rig):
    rig.far.call("rig.autopilot.refuse_arming", "Preflight Fail: made up")
    report = rig.flight().begin().end()
    assert report.end is End.NOT_FLOWN
    assert "arm" in report.message
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


def give_up_and_stand_still(flight: Flight, monkeypatch: pytest.MonkeyPatch, meanwhile: Callable[[], None]) -> None:
    """On the way back, as with a file on a disk that does not answer."""
    way, looks = flight.session.flight.way_back, []
    real = way._note

    def stands_still() -> None:
        looks.append(None)
        if len(looks) == 20:
            meanwhile()
        real()

    monkeypatch.setattr(way, "_note", stands_still)
    flight.session.terminate()


def test_a_session_that_stands_still_on_its_way_back(rig, monkeypatch):
    """The supervisor flies the rest."""
    monkeypatch.setattr(supervisor_module, "SILENT_WITHIN", 1.5)
    flight = swinging(rig)

    def until_landed() -> None:
        until(lambda: not rig.links.autopilot.state().armed, "landed by the supervisor", flight.told)

    give_up_and_stand_still(flight, monkeypatch, until_landed)
    report = flight.end()
    assert report.end is End.LANDED
    assert found(report) == {Fault.TERMINATED, Fault.SESSION_SILENT, Fault.SESSION}
    assert not rig.collided
    assert_down(rig)
    assert_before_the_door(rig)


def test_a_session_that_stood_still_flies_on(rig, monkeypatch):
    """The hold that the supervisor latched meanwhile does not keep it from the rest of its way."""
    monkeypatch.setattr(supervisor_module, "SILENT_WITHIN", 1.0)
    flight = swinging(rig)
    findings = flight.session.supervisor.findings

    def until_flown() -> None:
        until(lambda: any(finding.fault is Fault.SESSION_SILENT for finding in findings), "silence", flight.told)
        time.sleep(supervisor_module.ACKNOWLEDGE_WITHIN + 0.5)

    give_up_and_stand_still(flight, monkeypatch, until_flown)
    report = lands_on_the_pad(rig, flight)
    assert found(report) == {Fault.TERMINATED, Fault.SESSION_SILENT}


def test_autopilot_reboots(rig):
    flight = at_hover(rig)
    rig.far.call("rig.autopilot.reboot")
    report = flight.end()
    assert report.end in (End.FALLEN, End.TAKEN_OVER)
    assert report.message, "whoever sees it first says so"
    until(lambda: rig.snapshot.on_ground, "on the ground")


def test_motors_are_stopped_by_the_pilot(rig):
    flight = at_hover(rig)
    rig.far.call("rig.autopilot.kill_switch")
    report = flight.end()
    told = End.FALLEN if AUTOPILOT == "px4" else End.LANDED  # ArduPilot's says nothing until it disarms, 5 s later
    assert (report.end, report.completed) == (told, False)
    assert report.message, "whoever sees it first says so"
    until(lambda: rig.snapshot.on_ground, "on the ground")
