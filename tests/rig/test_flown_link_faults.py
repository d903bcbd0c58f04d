"""A line to the autopilot that is cut or late."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from flight_ends import assert_at_the_pad, assert_before_the_door, assert_down, at_hover, found, lands, swinging
from flight_rig import FlightRig, until

from doorman.flight import End
from doorman.hardware.pixhawk import EventKind
from doorman.hardware.safety import Action, Fault


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
    """The autopilot's failsafe flies away meanwhile: the door must be let go of before it pulls.

    The supervisor says so, or the mission itself: commands that do not arrive may make it seem that the leaf was lost.
    """
    flight = swinging(rig)
    until(lambda: np.degrees(rig.snapshot.truth.door_angle) < angle, "the angle")
    with link_cut(rig):
        until(lambda: not rig.links.holding, "an open gripper")
        assert not found(flight.session.supervisor) & {Fault.LINK, Fault.FORCE, Fault.DISOBEDIENCE}
        report = flight.end()
        assert report.end is End.UNHEARD
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
    report = lands(rig, flight)
    assert Fault.TELEMETRY_GRIPPING in found(report), "the door is let go of first"
    assert found(report) <= {Fault.TELEMETRY, Fault.TELEMETRY_GRIPPING}, "it gives up, flown by what the cameras see"


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
    report = lands(rig, flight, assert_before_the_door)
    assert Fault.TELEMETRY in found(report)
    assert Action.LAND not in {finding.action for finding in report.findings}


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
    lands(rig, flight, assert_before_the_door)


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
    lands(rig, flight, assert_before_the_door)
