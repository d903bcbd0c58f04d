"""Parts of the program that raise, hang or stand still."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import pytest
from flight_ends import (
    anywhere,
    assert_at_the_pad,
    assert_before_the_door,
    assert_down,
    at_hover,
    found,
    lands,
    swinging,
)
from flight_rig import Flight, until

from doorman.exceptions import DoormanError
from doorman.flight import End
from doorman.hardware.safety import Action, Fault
from doorman.hardware.safety import supervisor as supervisor_module


def test_controller_hangs_in_the_doorway(rig):
    """For longer than the supervisor waits: it flies the vehicle out by itself."""
    flight = swinging(rig)
    let_go = threading.Event()
    flight.on_progress = lambda: (let_go.wait(30.0), None)[1]
    until(lambda: flight.session.supervisor.action is Action.LAND, "the supervisor has flown it out, and lands")
    assert_before_the_door(rig)
    let_go.set()
    report = lands(rig, flight, anywhere)
    assert {Fault.CONTROLLER, Fault.SESSION} <= found(report)


def test_controller_hangs(rig):
    flight = rig.flight()
    hung_until: list[float] = []

    def hang() -> None:
        if not hung_until:
            hung_until.append(time.monotonic() + 4.0)
            time.sleep(4.0)

    flight.on_progress = hang
    report = lands(rig, flight.begin(), anywhere)
    (finding,) = [one for one in report.findings if one.fault is Fault.CONTROLLER]
    assert finding.time < hung_until[0], "landed while it hung"


def test_supervisor_hangs(rig):
    flight = at_hover(rig)
    real = flight.session.supervisor._look

    def hang():
        time.sleep(3.0)
        return real()

    flight.session.supervisor._look = hang
    report = lands(rig, flight, anywhere)
    assert "supervisor is silent" in report.message


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


def test_the_way_back_fails(rig, monkeypatch):
    """It lands where it is then, with the cameras' poses until it has."""
    flight = at_hover(rig)

    def broken() -> None:
        raise RuntimeError("made up")

    monkeypatch.setattr(flight.session.flight.way_back, "fly", broken)
    flight.session.terminate()
    report = lands(rig, flight, anywhere)
    assert found(report) == {Fault.TERMINATED, Fault.SESSION}
    assert any("made up" in words for words in flight.said)


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
    report = lands(rig, flight, assert_before_the_door)
    assert found(report) == {Fault.TERMINATED, Fault.SESSION_SILENT, Fault.SESSION}
    assert not rig.collided


def test_a_session_that_stood_still_flies_on(rig, monkeypatch):
    """The hold that the supervisor latched meanwhile does not keep it from the rest of its way."""
    monkeypatch.setattr(supervisor_module, "SILENT_WITHIN", 1.0)
    flight = swinging(rig)
    findings = flight.session.supervisor.findings

    def until_flown() -> None:
        until(lambda: any(finding.fault is Fault.SESSION_SILENT for finding in findings), "silence", flight.told)
        time.sleep(supervisor_module.ACKNOWLEDGE_WITHIN + 0.5)

    give_up_and_stand_still(flight, monkeypatch, until_flown)
    report = lands(rig, flight)
    assert found(report) == {Fault.TERMINATED, Fault.SESSION_SILENT}
