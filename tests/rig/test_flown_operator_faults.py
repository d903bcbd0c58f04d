"""What operator and pilot do in flight, and the end that the fault table promises."""

from __future__ import annotations

import time

import numpy as np
from flight_ends import anywhere, assert_at_the_pad, assert_down, at_hover, found, lands
from flight_rig import AUTOPILOT, Flight, until

from doorman.flight import End, FlightReport, way_back
from doorman.hardware.pixhawk import Authority
from doorman.hardware.safety import Action, Fault


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


def held(rig) -> Flight:
    """A door with a closer, which somebody would have to take."""
    rig.far.call("rig.plant.draw_shut", 1.0)
    flight = at_hover(rig)
    until(lambda: any(words.startswith("the door does not stay") for words in flight.said), "a held door", flight.told)
    return flight


def left(rig, flight: Flight) -> FlightReport:
    """Its leaf follows the vehicle out, at the tip."""
    report = lands(rig, flight)
    assert "retreat" in flight.recording["mission"]["state"], "the mission's own controller flew back"
    assert not report.completed
    return report


def test_a_door_that_would_not_stay_is_held_until_the_operator_gives_up(rig, monkeypatch):
    monkeypatch.setattr(way_back, "OPERATOR_PATIENCE", 1.0)
    flight = held(rig)
    time.sleep(2.0 * rig.model.scenario.mission.hold_open)
    assert flight.session.phase == "hold"
    assert abs(rig.snapshot.truth.door_angle - rig.model.goal_angle) < np.radians(2.0)
    flight.session.interrupt()
    assert found(left(rig, flight)) == {Fault.OPERATOR_ABORT}


def test_a_door_that_nobody_takes_is_left(rig):
    report = left(rig, held(rig))
    assert "let go after" in report.message and not report.findings


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
    report = lands(rig, flight, anywhere)
    assert Fault.OPERATOR_LAND in found(report)


def test_process_is_asked_to_end_while_it_rises(rig):
    flight = rig.flight().begin()
    until(lambda: rig.snapshot.truth.position[2] > 0.5, "a vehicle that rises", flight.told)
    flight.session.terminate()
    until(lambda: flight.session.supervisor.action is Action.LAND, "its way has not begun")
    assert flight.end().end is End.LANDED
    assert_down(rig)


def test_process_is_asked_to_end_again(rig):
    flight = at_hover(rig)
    flight.session.terminate()
    flight.session.terminate()
    time.sleep(1.2)
    assert flight.session.supervisor.action is Action.RETREAT, "the same signal, by group and parent"
    flight.session.terminate()
    report = lands(rig, flight, anywhere)
    assert found(report) == {Fault.TERMINATED, Fault.OPERATOR_LAND}


def test_pilot_takes_over(rig):
    flight = at_hover(rig)
    rig.far.call("rig.autopilot.pilot_mode", "position")
    until(lambda: rig.links.autopilot.status().authority is Authority.LOST, "the takeover")
    time.sleep(3.0)
    assert rig.links.mocap.read().fresh, "without poses the pilot could not hold a position"
    assert rig.snapshot.motors
    rig.far.call("rig.autopilot.pilot_mode", "land")
    report = lands(rig, flight, anywhere)
    assert found(report) <= {Fault.PILOT}, "or the backend saw it first"


def test_motors_are_stopped_by_the_pilot(rig):
    flight = at_hover(rig)
    rig.far.call("rig.autopilot.kill_switch")
    report = flight.end()
    told = End.FALLEN if AUTOPILOT == "px4" else End.LANDED  # ArduPilot's says nothing until it disarms, 5 s later
    assert (report.end, report.completed) == (told, False)
    assert report.message, "whoever sees it first says so"
    until(lambda: rig.snapshot.on_ground, "on the ground")
