"""Cameras or autopilot that do not know where the vehicle is."""

from __future__ import annotations

import pytest
from flight_ends import assert_before_the_door, assert_down, at_hover, found, swinging

from doorman.flight import End
from doorman.hardware.safety import Fault


@pytest.mark.parametrize("fault", ["silent", "frozen", "zeroed"])
def test_cameras_lose_the_vehicle(rig, fault):
    flight = at_hover(rig)
    rig.far.set(f"rig.mocap.faults.{fault}", True)
    report = flight.end()
    assert report.end is End.LANDED
    assert Fault.POSE in found(report)
    assert Fault.SESSION not in found(report), "the program itself flew it back"
    assert_down(rig)


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
