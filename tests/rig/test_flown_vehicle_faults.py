"""Battery, wind, arming and an autopilot that starts again."""

from __future__ import annotations

import pytest
from flight_ends import assert_at_the_pad, assert_down, at_hover, found, swinging
from flight_rig import until

from doorman.flight import End
from doorman.hardware.pixhawk import Outcome, OutcomeStatus
from doorman.hardware.safety import Fault


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


def test_wind_pushes_too_hard(rig):
    flight = at_hover(rig)
    rig.far.call("rig.plant.blow", (-25.0, 0.0, 0.0))
    until(lambda: flight.session.supervisor.findings, "a finding")
    rig.far.call("rig.plant.blow", (0.0, 0.0, 0.0))
    report = flight.end()
    assert report.end is End.LANDED
    assert found(report) & {Fault.FORCE, Fault.SPEED, Fault.TILT}
    assert_down(rig)


def test_arming_refused(rig):
    rig.far.set("rig.autopilot.brain.refusal", "Preflight Fail: made up")
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


def test_autopilot_reboots(rig):
    flight = at_hover(rig)
    rig.far.call("rig.autopilot.reboot")
    report = flight.end()
    assert report.end in (End.FALLEN, End.TAKEN_OVER)
    assert report.message, "whoever sees it first says so"
    until(lambda: rig.snapshot.on_ground, "on the ground")
