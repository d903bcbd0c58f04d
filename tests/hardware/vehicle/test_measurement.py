"""Measurement composed of the links' samples: what is fresh is carried on rightly, what is old is an error."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
from attitude_matrices import euler_rate_matrix

from doorman.exceptions import BackendError
from doorman.hardware.dynamixel import BusState, ServoFault, ServoSample
from doorman.hardware.mocap.sample import measured
from doorman.hardware.pixhawk import SampleStatus, VehicleSample
from doorman.hardware.vehicle import vehicle_config
from doorman.hardware.vehicle.backend import Ticker
from doorman.hardware.vehicle.measurement import compose
from doorman.kinematics.rotations import quaternion_of
from doorman.model import Model
from doorman.scenario import Scenario

NOW, OPENED = 50.0, 40.0
CONFIG = vehicle_config(Model(Scenario()), "udp:14540", "/dev/null", "udp:51001", links={"servo_patience": 0.15})
RATES = np.array([0.2, -0.3, 0.5])
ATTITUDE = np.array([0.1, -0.2, 0.7])
VEHICLE = VehicleSample(
    status=SampleStatus.FRESH, attitude_time=NOW - 0.004, position_time=NOW - 0.03, position=np.array([1.0, 2.0, 3.0]),
    velocity=np.array([0.5, 0.0, -0.1]), attitude=ATTITUDE, quaternion=np.array(quaternion_of(ATTITUDE)), body_rates=RATES,
)  # fmt: skip
SERVOS = ServoSample(
    time=NOW - 0.01, angles=np.array([0.1, 0.2, 0.3, 0.4, 0.8]), rates=np.array([1.0, -1.0, 0.0, 2.0, 0.0]),
    currents=np.zeros(5), temperatures=np.full(5, 30.0), voltages=np.full(5, 12.0), errors=(0,) * 5,
    times=np.full(5, NOW - 0.01), faults=(ServoFault.NONE,) * 5, bus_fault=ServoFault.NONE, state=BusState.FOLLOWING,
    goals=np.zeros(5), cycle=7, age=0.01, fresh=True,
)  # fmt: skip
POSE, TURNING = (
    measured(NOW - 0.02, (-1.0, 0.7, 1.3), quaternion_of(ATTITUDE), (0.1, 0.2, 0.3), (0.0, 0.0, turn), 5, 9)
    for turn in (0.0, 0.4)
)


def at(**changes):
    given = {"vehicle": VEHICLE, "servos": SERVOS, "pose": POSE} | changes
    return compose(NOW, OPENED, given["vehicle"], given["servos"], given["pose"], CONFIG)


def test_position_is_that_of_the_cameras_with_its_own_time():
    measurement = at()
    assert measurement.time == pytest.approx(NOW - OPENED)
    assert measurement.pose_time == pytest.approx(NOW - OPENED - 0.02)
    assert measurement.position.tolist() == [-1.0, 0.7, 1.3]
    assert measurement.velocity.tolist() == [0.1, 0.2, 0.3]


@pytest.mark.parametrize("status", [SampleStatus.FRESH, SampleStatus.STALE])
@pytest.mark.parametrize(("age", "rates"), [(0.06, RATES), (0.08, np.array([0.0, 0.0, 0.4]))])
def test_an_autopilot_that_is_not_heard_for_a_while_is_replaced_by_the_cameras(status, age, rates):
    """Their rates are those of 50 ms before the pose, which is 20 ms old."""
    measurement = at(vehicle=replace(VEHICLE, status=status, attitude_time=NOW - age), pose=TURNING)
    assert measurement.body_rates.tolist() == rates.tolist()
    assert measurement.attitude == pytest.approx(ATTITUDE) and measurement.pose_time == pytest.approx(
        NOW - OPENED - 0.02
    )


def test_without_cameras_it_is_that_of_the_autopilot():
    measurement = at(pose=None)
    assert measurement.pose_time == pytest.approx(NOW - OPENED - 0.03)
    assert measurement.position.tolist() == [1.0, 2.0, 3.0]


def test_the_force_of_the_tip_is_what_its_sensor_reads():
    assert at().tip_force is None
    assert compose(NOW, OPENED, VEHICLE, SERVOS, POSE, CONFIG, 0.8).tip_force == 0.8


@pytest.mark.parametrize(("pose", "later"), [(POSE, 0.0), (None, 0.026)])
def test_attitude_is_that_of_the_position_s_time(pose, later):
    """The autopilot tells both at times of their own."""
    expected = ATTITUDE - later * euler_rate_matrix(ATTITUDE) @ RATES
    measurement = at(pose=pose)
    assert measurement.attitude == pytest.approx(expected, abs=1e-4)


def test_joint_angles_are_carried_on_and_the_gripper_left_out():
    measurement = at()
    assert measurement.arm_angles == pytest.approx([0.11, 0.19, 0.3, 0.42])
    assert measurement.arm_rates.tolist() == [1.0, -1.0, 0.0, 2.0]
    assert measurement.body_rates.tolist() == RATES.tolist()


def test_angles_of_an_arm_that_is_not_heard_are_not_carried_on_for_long():
    measurement = at(servos=replace(SERVOS, time=NOW - 0.14, times=np.full(5, NOW - 0.14), age=0.14, fresh=False))
    assert measurement.arm_angles[0] == pytest.approx(0.1 + 0.05)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"vehicle": replace(VEHICLE, status=SampleStatus.STALE), "pose": None}, "pixhawk"),
        ({"vehicle": replace(VEHICLE, status=SampleStatus.INCOMPLETE)}, "pixhawk"),
        ({"vehicle": VehicleSample()}, "pixhawk"),
        ({"servos": replace(SERVOS, age=0.2, fresh=False)}, "servos"),
    ],
)
def test_what_is_old_is_an_error(change, field):
    with pytest.raises(BackendError) as error:
        at(**change)
    assert error.value.field == field


def test_ticks_stand_on_a_grid_and_are_never_early():
    ticker = Ticker(0.005)
    first = ticker.wait()
    for count in range(1, 21):
        tick = ticker.wait()
        assert (tick - first) / 0.005 >= count - 1e-6
    assert ticker.statistics().ticks == 21


def test_missed_ticks_are_counted_and_not_made_up_for():
    ticker = Ticker(0.005)
    ticker.wait()
    time.sleep(0.0525)
    late = ticker.wait()
    after = ticker.wait()
    assert ticker.missed >= 9
    assert after - late > 0.0
    figures = ticker.statistics()
    assert figures.longest >= 0.0525
    assert figures.missed == ticker.missed
    assert figures.ticks == 3
