"""Whole flights over real sockets, with both autopilots and both kinds of setpoints."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from pixhawk_rig import QUICK, WEIGHT, Rig, wait_until
from virtual_time import CLOCK, Aside

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk import (
    AttitudeSetpoint,
    Authority,
    EventKind,
    LandedState,
    LocalFrame,
    OutcomeStatus,
    PositionSetpoint,
    SampleStatus,
)
from doorman.hardware.pixhawk.link.stream import Source
from doorman.rig.emulators.autopilot.dialects import ACCEPTED
from doorman.rig.emulators.autopilot.estimator import PlantTruth, SimplePlant


def fly_to(rig: Rig, target: list[float], mass: float = 3.0) -> bool:
    """Fly by attitude and thrust from the adapter's state alone; returns whether the vehicle got there and stood still."""
    goal = np.array(target)

    def there() -> bool:
        sample = rig.pilot.state()
        acceleration = 4.0 * (goal - sample.position) - 3.0 * sample.velocity
        attitude = np.array([-acceleration[1], acceleration[0], 0.0]) / 9.81
        setpoint = AttitudeSetpoint(mass * (9.81 + acceleration[2]), np.clip(attitude, -0.4, 0.4))
        assert rig.pilot.setpoint(setpoint)
        truth = rig.emulator.truth
        return bool(np.linalg.norm(truth.position - goal) < 0.1 and np.linalg.norm(truth.velocity) < 0.1)

    return wait_until(there)


def test_a_flight_by_attitude_and_thrust(rigs, flavour):
    """From take-off over calibration to landing; at first the autopilot's own figure for hover is wrong."""
    rig = rigs(flavour, {"thrust_curve": None, "hover_force": WEIGHT}, hover_thrust=0.33)
    rig.emulator.parameters["MPC_THR_HOVER" if flavour == "px4" else "MOT_THST_HOVER"] = 0.5
    rig.fly()
    assert rig.pilot.status().authority is Authority.ENGAGED
    assert wait_until(lambda: rig.pilot.calibrate_hover(WEIGHT, 0.8).hover_thrust == pytest.approx(0.33, rel=0.02))
    assert fly_to(rig, [0.25, -0.25, 0.4])
    status = rig.pilot.status()
    assert status.source is Source.CONTROLLER
    assert status.dialect == ("PX4" if flavour == "px4" else "ArduPilot")
    rig.pilot.setpoint(AttitudeSetpoint(WEIGHT, np.array([0.0, 0.3, 0.0])))
    assert wait_until(lambda: rig.emulator.brain.demand.quaternion[2] == pytest.approx(math.sin(0.15), abs=1e-3))
    # ArduPilot divides the thrust by the cosine of the tilt, the adapter multiplies before
    assert rig.emulator.brain.demand.thrust == pytest.approx(0.33, rel=0.03), "along the body's axis, not the vertical"
    assert rig.pilot.land().done
    assert rig.emulator.truth.on_ground and not rig.emulator.brain.armed
    assert rig.pilot.status().authority is Authority.NONE


def test_a_flight_by_position_with_a_turned_local_frame(rigs, flavour):
    """The world's axes are not the autopilot's: its north points along the world's y, its origin lies elsewhere."""
    frame = LocalFrame((5.0, 1.0, 0.5), math.pi / 2)
    rig = rigs(flavour, {"setpoints": "position", "local_frame": frame, "thrust_curve": None}).fly()
    start = rig.pilot.state().position
    goal = start + [0.5, 0.0, 0.2]
    yaw = float(rig.pilot.state().attitude[2]) + 0.5

    def there() -> bool:
        assert rig.pilot.setpoint(PositionSetpoint(goal, yaw, velocity=np.zeros(3), acceleration=np.zeros(3)))
        return bool(np.linalg.norm(rig.pilot.state().position - goal) < 0.05)

    assert wait_until(there)
    assert wait_until(lambda: there() and abs(rig.pilot.state().attitude[2] - yaw) < 0.05)
    # one half metre along the world's x is half a metre west of an autopilot whose north is the world's y
    assert rig.emulator.truth.position[1] == pytest.approx(-0.5, abs=0.1)
    assert abs(rig.emulator.truth.position[0]) < 0.1


def fed(rig: Rig, condition: Callable[[], object], delay: float = 0.0) -> bool:
    """Whether a condition comes true while poses come, each so late [s]."""
    taken: deque[tuple[float, PlantTruth]] = deque()

    def look() -> bool:
        taken.append((CLOCK.now(), rig.emulator.truth))
        while taken and CLOCK.now() - taken[0][0] >= delay:
            captured, truth = taken.popleft()
            rig.pilot.mocap(captured, truth.position, truth.quaternion)
        return bool(condition())

    return wait_until(look, 20.0)


def fresh(rig: Rig) -> bool:
    return rig.pilot.state().status is SampleStatus.FRESH


def test_a_flight_by_mocap_alone(rigs, flavour):
    rig = rigs(flavour, {"mocap": True}, vision=True, pace=1.0).open()
    assert rig.pilot.state().status is SampleStatus.INCOMPLETE or flavour == "px4"
    if flavour == "px4":
        outcome = rig.pilot.engage()
        assert outcome.status is OutcomeStatus.NOT_READY and "mocap" in outcome.message
    estimator, receiver, delay = rig.emulator.estimator, rig.emulator.receiver, 0.02
    assert fed(rig, lambda: estimator.estimate.position_valid and fresh(rig), delay)
    assert fed(rig, lambda: receiver.companion_clock.answers > 22 or flavour == "ardupilot", delay)
    statistics = rig.pilot.status().mocap
    assert statistics.median_delay >= delay and statistics.sent >= 10
    assert np.linalg.norm(estimator.estimate.position - rig.emulator.truth.position) < 0.01
    if flavour == "ardupilot":
        assert receiver.received["SET_GPS_GLOBAL_ORIGIN"] >= 1
    else:
        assert receiver.companion_clock.offset == pytest.approx(rig.emulator.clock.now - CLOCK.now(), abs=0.01)


def test_the_height_of_ardupilot_is_that_of_mocap_and_its_origin_is_given_again_where_it_forgets_it(rigs):
    """It calls zero the height at which it stands when it gets its origin: poses that came before would be off by it."""
    rig = rigs("ardupilot", {"mocap": True}, vision=True, pace=1.0, plant=SimplePlant(ground=0.4)).open()
    assert fed(rig, lambda: fresh(rig) and rig.pilot.status().on_earth)
    heights, begin = [], CLOCK.now()
    assert fed(rig, lambda: heights.append(rig.pilot.state().position[2]) or CLOCK.now() > begin + 1.5)
    assert np.abs(np.array(heights) - 0.4).max() < 0.05
    rig.emulator.estimator.origin = None
    assert fed(rig, lambda: rig.emulator.estimator.origin is not None)
    assert fed(rig, lambda: rig.pilot.status().on_earth and fresh(rig))
    assert float(rig.pilot.state().position[2]) == pytest.approx(0.4, abs=0.05)


def test_px4_gets_a_place_on_earth_before_its_poses(rigs):
    """Without one it has no home; with one that comes later its position would jump."""
    rig = rigs("px4", {"mocap": True}, vision=True).open()
    assert fed(rig, lambda: rig.emulator.estimator.estimate.on_earth)
    assert rig.emulator.receiver.received["SET_GPS_GLOBAL_ORIGIN"] == 1
    assert fed(rig, lambda: np.linalg.norm(rig.pilot.state().position - rig.emulator.truth.position) < 0.05)
    rig.emulator.pilot_mode("return")
    assert fed(rig, lambda: rig.emulator.brain.is_in("return"))


def test_an_autopilot_with_a_slow_loop_is_heard_more_rarely(rigs):
    rig = rigs("ardupilot", pace=1.0)
    rig.emulator.parameters["SCHED_LOOP_RATE"] = 150
    rig.open()
    assert wait_until(lambda: 80.0 < rig.pilot.status().rates["ATTITUDE_QUATERNION"] < 120.0)
    status = rig.pilot.status()
    assert status.asked_rates["ATTITUDE_QUATERNION"] == 100.0 and status.wanted_rates["ATTITUDE_QUATERNION"] == 200.0


def test_attitude_setpoints_need_a_thrust_curve_and_thrust(rigs):
    rig = rigs("px4", {"thrust_curve": None}).open()
    outcome = rig.pilot.engage()
    assert outcome.status is OutcomeStatus.NOT_READY and "thrust curve" in outcome.message
    with pytest.raises(BackendError, match="thrust_curve.*hover_force"):
        rig.pilot.setpoint(AttitudeSetpoint(10.0, np.zeros(3)))
    other = rigs("ardupilot")
    other.emulator.parameters["GUID_OPTIONS"] = 0
    outcome = other.open().pilot.engage()
    assert outcome.status is OutcomeStatus.NOT_READY and "GUID_OPTIONS" in outcome.message
    assert other.emulator.brain.mode == 0, "nothing was asked of the autopilot"


def test_setpoints_are_refused_while_the_vehicle_is_not_ours(rigs, flavour):
    rig = rigs(flavour).open()
    setpoint = AttitudeSetpoint(WEIGHT, np.zeros(3))
    assert not rig.pilot.setpoint(setpoint)
    assert rig.pilot.take_off(0.5).status is OutcomeStatus.NOT_READY
    assert rig.pilot.hold().status is OutcomeStatus.CONTROL_LOST
    assert not rig.pilot.request_landing()
    assert rig.pilot.land().done, "disarmed on the ground: nothing to do"
    with pytest.raises(BackendError, match="height"):
        rig.pilot.take_off(1e3)


def test_a_latched_hold_keeps_the_controller_out_until_it_is_released(hovering):
    rig = hovering("px4")
    setpoint = PositionSetpoint(rig.pilot.state().position.copy(), 0.0)
    assert rig.pilot.setpoint(setpoint)
    assert rig.pilot.hold(latch=True).done
    assert not rig.pilot.setpoint(setpoint)
    assert rig.pilot.status().source is Source.HOLD
    rig.pilot.resume()
    assert rig.pilot.setpoint(setpoint)


def test_closing_in_the_air_lands_what_is_ours(rigs):
    rig = rigs("ardupilot")
    rig.emulator.open()
    with pytest.raises(RuntimeError, match="controller"), rig.pilot as pilot:
        assert wait_until(lambda: pilot.state().status is SampleStatus.FRESH)
        assert pilot.engage().done and pilot.arm().done and pilot.take_off(0.3).done
        raise RuntimeError("controller")
    rig.pilot.stop()
    assert wait_until(lambda: not rig.emulator.brain.armed)
    assert rig.emulator.truth.on_ground
    assert rig.pilot.state().status is not SampleStatus.FRESH


def test_a_link_opens_once_at_a_time_and_again_after_it_was_closed(rigs):
    rig = rigs("px4").open()
    with pytest.raises(BackendError, match="open already"):
        rig.pilot.open()
    rig.pilot.stop()
    rig.pilot.open()
    assert wait_until(lambda: rig.pilot.state().status is SampleStatus.FRESH)


def test_disarming_on_the_ground(rigs, flavour):
    rig = rigs(flavour).open()
    assert rig.pilot.engage().done and rig.pilot.arm().done and rig.pilot.disarm().done
    assert not rig.emulator.brain.armed
    assert rig.pilot.status().authority is Authority.NONE
    assert wait_until(lambda: rig.pilot.state().landed is LandedState.ON_GROUND)


def test_we_are_the_ground_station_whose_loss_the_autopilot_notices(rigs):
    rig = rigs("px4").open()
    assert wait_until(lambda: rig.emulator.receiver.received["HEARTBEAT"] >= 2)
    assert rig.emulator.receiver.heartbeat_types == {(255, 190, 6)}
    assert rig.emulator.receiver.station_heard > float("-inf")
    rig.happens(EventKind.CONNECTED)


def test_what_keeps_an_older_px4_from_offboard_is_told(rigs, monkeypatch):
    """Without a radio PX4 1.13 accepts the mode, and takes the lost radio's instead."""
    rig = rigs("px4", {"timeouts": replace(QUICK, mode=0.5)}).open()
    monkeypatch.setattr(rig.emulator.brain, "request_mode", lambda mode: ACCEPTED)
    outcome = rig.pilot.engage()
    assert outcome.status is OutcomeStatus.TIMED_OUT and "COM_RCL_EXCEPT" in outcome.message


def test_why_it_would_not_arm_is_told_when_asked(rigs, flavour):
    rig = rigs(flavour).open()
    rig.emulator.brain.refusal = "PreArm: made up"
    CLOCK.sleep(0.5)
    assert rig.pilot.complaints() == ()
    assert rig.pilot.check_again() == ("PreArm: made up",)


def test_a_disarming_that_was_refused_is_forgotten(rigs):
    rig = rigs("px4").fly()
    assert rig.pilot.disarm().status is OutcomeStatus.REFUSED
    rig.emulator.pilot_disarms()
    assert "disarmed" in rig.happens(EventKind.CONTROL_LOST).message


def test_a_vehicle_that_is_to_land_is_not_armed(rigs):
    rig = rigs("px4").open()
    assert rig.pilot.engage().done
    rig.emulator.brain.refusal = "PreArm: gyros"
    landing = Aside(rig.pilot.request_landing, after=0.5)
    began = CLOCK.now()
    outcome = rig.pilot.arm(60.0)
    landing.result()
    assert outcome.status is OutcomeStatus.NOT_READY and "land" in outcome.message
    assert CLOCK.now() - began < 5.0


def test_arming_is_seen_by_a_heartbeat_that_comes_late(rigs):
    rig = rigs("px4", heartbeat_rate=1.0).open()
    assert rig.pilot.engage().done
    assert rig.pilot.arm(0.2).done and rig.pilot.state().armed
