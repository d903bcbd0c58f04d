"""Cameras that find the vehicle elsewhere, against an autopilot that has felt its motion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import cast

import numpy as np
import pytest
from mocap_rig import Rig, start_rig, swaying, true_position
from virtual_time import CLOCK

from doorman.hardware.mocap import MocapReceiver, PoseQuality
from doorman.hardware.pixhawk import Autopilot, SampleStatus, VehicleSample
from doorman.hardware.vehicle.doubt import BELIEVED, BELIEVED_TURN, DOUBTED, DOUBTED_TURN, Doubt
from doorman.kinematics.quaternions import from_rotation_vector, multiply


class Inertial:
    """What an autopilot says that has followed every motion, up to an error."""

    armed, status, error, turn = True, SampleStatus.FRESH, 0.0, 0.0

    def state(self) -> VehicleSample:
        now = CLOCK.now()
        where = np.array(true_position(now)) + (self.error, 0.0, 0.0)
        turn = multiply(tuple(swaying(now).quaternion), from_rotation_vector((0.0, 0.0, self.turn)))
        return VehicleSample(self.status, position=where, quaternion=np.array(turn), armed=self.armed)


@pytest.fixture
def autopilot() -> Inertial:
    return Inertial()


@pytest.fixture
def seen(autopilot: Inertial) -> Iterator[Rig]:
    tracked = start_rig()
    tracked.doubt = Doubt(cast(Autopilot, autopilot), tracked.config.position_slack)
    tracked.receiver = MocapReceiver(tracked.config, CLOCK, judge=tracked.doubt)
    try:
        with tracked.receiver:
            tracked.until_fresh()
            yield tracked
    finally:
        tracked.emulator.stop()


def stays_usable(seen: Rig) -> None:
    for _ in range(20):
        assert seen.receiver.wait(seen.receiver.read(), 1.0).usable


def let_jump(seen: Rig, *by: float) -> None:
    """Let the body jump, and wait until its track has begun anew."""
    before = seen.receiver.read().track
    seen.emulator.faults.jump = by
    seen.until(lambda sample: sample.track > before)


def test_a_vehicle_found_elsewhere_is_lost_until_it_is_found_where_it_is(seen: Rig) -> None:
    before = seen.receiver.read().count
    seen.emulator.faults.jump = (0.5, 0.3, 0.0)
    seen.until_lost()
    far = seen.until(lambda sample: sample.count > before + 20)  # its track has begun anew, away from the autopilot
    assert np.linalg.norm(far.position - true_position(far.time)) > DOUBTED
    for _ in range(20):
        newest = seen.receiver.wait(far, 1.0)
        assert newest.quality is PoseQuality.LOST
        assert not newest.fresh
    seen.heal()
    seen.until_fresh()


def lose_and_find(seen: Rig) -> None:
    """The body is out of sight for a moment, and then found where it is."""
    seen.emulator.faults.silent = True
    seen.until_lost()
    seen.heal()


def test_the_error_of_dead_reckoning_is_no_reason_to_doubt(seen: Rig, autopilot: Inertial) -> None:
    autopilot.error = 0.8 * DOUBTED
    lose_and_find(seen)
    stays_usable(seen)
    autopilot.error = 1.3 * DOUBTED
    seen.until_lost()
    autopilot.error = 0.5 * (DOUBTED + BELIEVED)  # between the two: as before
    CLOCK.sleep(0.05)
    assert not seen.receiver.read().usable
    autopilot.error = 0.5 * BELIEVED
    seen.until_fresh()


def test_an_autopilot_that_goes_astray_while_the_cameras_follow_gets_their_poses(
    seen: Rig, autopilot: Inertial
) -> None:
    """They are all that can bring it back; that both disagree is told to the supervisor by their distance."""
    seen.until_fresh()
    autopilot.error = 2.0 * DOUBTED
    stays_usable(seen)
    lose_and_find(seen)
    seen.until(lambda sample: seen.doubt.holds)
    assert not seen.receiver.read().usable
    autopilot.error = 0.0
    seen.until_fresh()
    autopilot.error = 2.0 * DOUBTED  # both have agreed since
    stays_usable(seen)


def test_a_body_within_reach_that_is_taken_for_it_after_a_moment_is_doubted(seen: Rig) -> None:
    """The longer the vehicle is out of sight, the farther it may have flown."""
    let_jump(seen, 0.3, 0.3, 0.0)
    seen.until_lost()
    assert seen.doubt.holds


@pytest.mark.parametrize("jump", [(0.03, 0.0, 0.0), (0.0, 0.1, 0.0)])
def test_poses_that_jump_are_lost_until_they_jump_back(seen: Rig, jump: tuple[float, float, float]) -> None:
    """They are near to where the autopilot is, and will be nearer once it has taken them in."""
    let_jump(seen, *jump)
    end = CLOCK.now() + 1.0
    while CLOCK.now() < end:
        assert not seen.receiver.wait(seen.receiver.read(), 1.0).usable
    seen.heal()
    seen.until_fresh()


def test_a_vehicle_that_takes_off_after_a_jump_believes_its_cameras(seen: Rig, autopilot: Inertial) -> None:
    autopilot.armed = False
    let_jump(seen, 0.1, 0.0, 0.0)
    autopilot.armed = True
    stays_usable(seen)


def test_poses_that_something_else_contradicts_are_lost_until_the_vehicle_stands(
    seen: Rig, autopilot: Inertial
) -> None:
    seen.until_fresh()
    seen.doubt.distrust()
    seen.until_lost()
    CLOCK.sleep(1.0)
    assert not seen.receiver.read().usable
    autopilot.armed = False
    seen.until_fresh()
    autopilot.armed = True
    seen.until_fresh()


def test_a_vehicle_whose_markers_are_taken_for_each_other_is_lost(seen: Rig, autopilot: Inertial) -> None:
    """A hexarotor looks the same after a sixth of a turn."""
    autopilot.turn = 0.8 * BELIEVED_TURN
    stays_usable(seen)
    autopilot.turn = np.pi / 3.0
    seen.until_lost()
    autopilot.turn = 0.5 * (DOUBTED_TURN + BELIEVED_TURN)  # between the two: as before
    CLOCK.sleep(0.05)
    assert not seen.receiver.read().usable
    autopilot.turn = 0.5 * BELIEVED_TURN
    seen.until_fresh()


@pytest.mark.parametrize(("armed", "status"), [(False, SampleStatus.FRESH), (True, SampleStatus.STALE)])
def test_an_autopilot_that_does_not_know_contradicts_nobody(
    seen: Rig, autopilot: Inertial, armed: bool, status: SampleStatus
) -> None:
    autopilot.error, autopilot.armed, autopilot.status = 5.0, armed, status
    stays_usable(seen)
