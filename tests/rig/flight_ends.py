"""Where a fault is injected, and the ends of flights that the fault table promises."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from flight_rig import Flight, FlightRig, until

from doorman.flight import End, FlightReport
from doorman.hardware.safety import Fault, Supervisor

Injection = Callable[[FlightRig, Flight], object]
"""What makes a fault begin."""


def put(path: str, value: object) -> Injection:
    """Set an attribute of the rig."""
    return lambda rig, _: rig.far.set(path, value)


def call(path: str, *arguments: object) -> Injection:
    return lambda rig, _: rig.far.call(path, *arguments)


def at_hover(rig: FlightRig) -> Flight:
    return rig.flight().begin().until_phase("hover", "approach")


def swinging(rig: FlightRig) -> Flight:
    """In the doorway, with the door in the gripper."""
    flight = at_hover(rig).until_phase("open")
    until(lambda: np.degrees(rig.snapshot.truth.door_angle) < 60.0, "a door that swings")
    return flight


def found(of: FlightReport | Supervisor) -> set[Fault]:
    return {finding.fault for finding in of.findings}


def assert_down(rig: FlightRig) -> None:
    """On the ground, upright, motors off, and nothing was touched."""
    until(lambda: not rig.snapshot.motors and rig.snapshot.on_ground, "on the ground, motors off")
    truth = rig.snapshot.truth
    assert np.abs(truth.attitude[:2]).max() < 0.1
    assert not rig.collided


def assert_at_the_pad(rig: FlightRig) -> None:
    away = rig.snapshot.truth.position[:2] - rig.places.pad[:2]
    assert np.linalg.norm(away) < 0.3


def assert_before_the_door(rig: FlightRig) -> None:
    disc = rig.model.vehicle.radius
    assert rig.snapshot.truth.position[0] < rig.model.door.hinge_position[0] - disc - 0.1, "out of the doorway"


def anywhere(_: FlightRig) -> None:
    """It may land where it is."""


def lands(rig: FlightRig, flight: Flight, place: Callable[[FlightRig], None] = assert_at_the_pad) -> FlightReport:
    """The flight to its end, which is on the ground at a place."""
    report = flight.end()
    assert report.end is End.LANDED
    assert_down(rig)
    place(rig)
    return report
