"""The gripper's current: it closes against the spring, helps it to open, and rests where the fingers are open."""

from __future__ import annotations

import time
from contextlib import nullcontext
from types import SimpleNamespace

import pytest

from doorman.hardware.dynamixel import ServoFault
from doorman.hardware.vehicle import VehicleLinks, vehicle_config
from doorman.hardware.vehicle.gripper import CLOSED, CLOSES_WITHIN, HALF_OPEN, OPEN, OPENS_WITHIN, RATE, SHUT
from doorman.hardware.vehicle.gripper import gripper_current as current
from doorman.hardware.vehicle.links import GripCommand
from doorman.model import Model
from doorman.rig.emulated import SPRING
from doorman.rig.emulators.servos.unit import ServoSetup
from doorman.scenario import Scenario


@pytest.mark.parametrize(("begin", "closed", "end"), [(OPEN, True, SHUT), (SHUT, False, OPEN), (0.4, True, SHUT)])
def test_it_arrives_in_time(begin, closed, end):
    angle, step = begin, 0.005
    for _ in range(round((CLOSES_WITHIN if closed else OPENS_WITHIN) / step)):
        rate = (current(angle, closed) - SPRING) / ServoSetup.damping
        assert abs(rate) <= RATE
        angle = min(max(angle + step * rate, OPEN), SHUT)
    assert angle == end
    assert (angle > CLOSED) is closed


def test_the_spring_alone_opens_it():
    assert (SHUT - HALF_OPEN) / (SPRING / ServoSetup.damping) < OPENS_WITHIN


@pytest.mark.parametrize(
    ("told", "angle", "holds"),
    [
        (True, SHUT, True),
        (True, CLOSED - 0.01, False),
        (False, HALF_OPEN + 0.01, True),
        (False, HALF_OPEN - 0.01, False),
    ],
)
def test_fingers_that_jam_half_open_hold_on(told: bool, angle: float, holds: bool) -> None:
    now = time.monotonic()
    links = object.__new__(VehicleLinks)
    servos = SimpleNamespace(
        read=lambda: SimpleNamespace(times=[now], angles=[0.0, angle], faults=[ServoFault.NONE] * 2)
    )
    long_ago = now - 2.0 * OPENS_WITHIN
    links.__dict__.update(
        config=SimpleNamespace(gripper=True), servos=servos, _grip_command=GripCommand(told, long_ago)
    )
    assert links.holding is holds
    assert links.grip_failed is (holds is not told)


def test_links_that_are_opened_again_know_nothing_of_the_grip_before(monkeypatch):
    """Else a gripper that was told to hold an hour ago has failed at once."""
    links = VehicleLinks(vehicle_config(Model(Scenario()), "udp:14540", "/dev/null"))
    links._grip_command = GripCommand(True, time.monotonic() - 2.0 * CLOSES_WITHIN)
    for name in ("servos", "autopilot"):
        monkeypatch.setattr(links, name, nullcontext())
    links.open()
    assert not links.grip_failed
    links.stop()


def test_an_open_gripper_draws_no_current():
    assert current(OPEN, closed=False) == 0.0
