"""Servos that fail, and a gripper that does not open."""

from __future__ import annotations

import time

from flight_ends import at_hover, found, lands_on_the_pad, swinging
from flight_rig import until

from doorman.flight import End
from doorman.hardware.safety import Fault
from doorman.rig.emulated import SPRING
from doorman.rig.emulators.servos.unit import OVERLOAD


def test_gripper_fails_while_it_grips(rig):
    flight = swinging(rig)
    rig.far.call("set_register", rig.model.n_arm + 1, "hardware error status", OVERLOAD)
    assert Fault.GRIPPER in found(lands_on_the_pad(rig, flight))


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
