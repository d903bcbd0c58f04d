"""What the links are told of the vehicle, from a scenario and the command line."""

from __future__ import annotations

import math

import numpy as np
import pytest
from urdf_variants import write_arm_of

from doorman.cli.values import real_numbers
from doorman.exceptions import BackendError, DoormanError
from doorman.hardware.pixhawk import ThrustCurve
from doorman.hardware.vehicle import VehicleConfig, vehicle_config
from doorman.hardware.vehicle.config import servo_limits
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.model import Model
from doorman.scenario import Scenario


def test_the_local_frame_goes_from_the_command_line_to_the_autopilot_s_link():
    given = real_numbers("-1.5,2,0.25,1.5707963267948966", "--local-frame", 4)
    links = {"pixhawk.local_frame": {"origin": given[:3], "yaw": given[3]}}
    frame = vehicle_config(Model(Scenario()), "udp:14540", "/dev/null", links=links).pixhawk.local_frame
    np.testing.assert_allclose(frame.position_to_world([3.0, 0.0, -1.0]), [-1.5, 5.0, 1.25], atol=1e-12)  # 3 m north
    assert frame.yaw == pytest.approx(0.5 * math.pi)
    assert real_numbers(None, "--local-frame", 4) is None
    world = vehicle_config(Model(Scenario()), "udp:14540", "/dev/null").pixhawk.local_frame
    np.testing.assert_allclose(world.position_to_world([3.0, 0.0, -1.0]), [3.0, 0.0, 1.0], atol=1e-12)


@pytest.mark.parametrize("text", ["", "1,2,3", "1,2,3,4,5", "1,2,3,north", "1,2,3,nan", "1,2,3,inf"])
def test_other_frames_are_errors_that_name_the_option(text):
    with pytest.raises(DoormanError, match="--local-frame.*4 finite numbers"):
        real_numbers(text, "--local-frame", 4)


def configured(**settings: object) -> VehicleConfig:
    return vehicle_config(Model(Scenario()), "udp:14540", "/dev/null", "udp:51001", **settings)  # type: ignore[arg-type]


def test_every_setting_of_a_link_can_be_given_by_name():
    config = configured(
        links={
            "pixhawk.vehicle_system": 3, "pixhawk.min_voltage": 14, "pixhawk.rates.attitude": 50,
            "pixhawk.thrust_curve": {"hover_thrust": 0.5, "hover_force": 29.0, "hover_voltage": 15.2},
            "servos.baud_rate": 57600, "servos.homing_offsets": [0, 0, 10, 0, 0], "mocap.sender": "192.168.10.5",
            "mocap.origin_position": [1, 2, 0], "mocap.rate": 50.0, "servo_patience": 0.2,
        }
    )  # fmt: skip
    assert (config.pixhawk.vehicle_system, config.pixhawk.min_voltage, config.pixhawk.rates.attitude) == (3, 14.0, 50.0)
    assert config.pixhawk.rates.heartbeat == 2.0, "the others stay"
    assert config.pixhawk.thrust_curve == ThrustCurve(0.5, 29.0, hover_voltage=15.2)
    assert (config.servos.baud_rate, config.servos.homing_offsets) == (57600, (0, 0, 10, 0, 0))
    assert (config.mocap.sender, config.mocap.rate, config.servo_patience) == ("192.168.10.5", 50.0, 0.2)
    assert config.mocap.origin_position == [1, 2, 0]


def test_mounting_of_the_servos_may_be_given_as_arrays_of_integers():
    config = configured(links={"servos.ids": np.arange(11, 16), "servos.directions": [1, -1, -1, 1, 1]})
    assert (config.servos.ids, config.servos.directions) == ((11, 12, 13, 14, 15), (1, -1, -1, 1, 1))
    with pytest.raises(BackendError, match="servos.directions.*-0.5"):
        configured(links={"servos.directions": [1.0, -0.5, -1.0, 1.0, 1.0]})


@pytest.mark.parametrize(
    ("links", "words"),
    [
        ({"pixhawk.vehicel_system": 3}, "pixhawk.vehicel_system: no such setting.*vehicle_system"),
        ({"servo.baud_rate": 3}, "servo: no such setting.*pixhawk, servos"),
        ({"pixhawk.vehicle_system": "three"}, "pixhawk.vehicle_system.*'three'"),
        ({"pixhawk.vehicle_system": 300}, "vehicle_system: out of range.*300.*1 to 255"),
        ({"servos.watchdog": math.nan}, "servos.watchdog: out of range"),
        ({"servos.upper_limits": [1, 1, 1, 1, 1]}, "servos.upper_limits"),
        ({"pixhawk.rates": 5}, "pixhawk.rates"),
        ({"pixhawk.rates.position": 20, "pixhawk.rates": {"attitude": 50}}, "pixhawk.rates.position"),
        ({"pixhawk.rates": {"attitude": 50}, "rate": 3.0}, "vehicle.rate: out of range"),
        ({"rate": 100.0, "rate.fast": 1}, "rate: .*rate.fast"),
        ({"pixhawk": {"listen_only": True}}, "pixhawk.listen_only"),
        ({"pixhawk.origin": (math.nan, 8.0, 488.0)}, "origin: not a place on earth"),
        ({"pixhawk.origin": (250.0, 8.0, 488.0)}, "origin: not a place on earth"),
        ({"pixhawk.origin": (47.0, 8.0, 0.0)}, "origin: not a place on earth"),
    ],
)
def test_settings_that_do_not_exist_or_do_not_fit_are_errors_that_name_them(links, words):
    with pytest.raises(BackendError, match=words):
        configured(links=links)


def test_without_cameras_none_of_their_settings_is_taken():
    with pytest.raises(BackendError, match="mocap"):
        vehicle_config(Model(Scenario()), "udp:14540", "/dev/null", links={"mocap.rate": 50.0})


@pytest.mark.parametrize("ids", [(1, 2, 3, 4), (1, 2, 3, 4, 5, 6)])
def test_a_wrong_number_of_servos_is_an_error_of_its_key(ids):
    with pytest.raises(BackendError, match="servos.ids.*5 ids, .*then of the gripper"):
        configured(links={"servos.ids": ids})


@pytest.mark.parametrize("rate", [25.0, math.nan, 3000.0])
def test_cameras_that_are_too_slow_are_an_error_of_their_key(rate):
    with pytest.raises(BackendError, match="mocap.rate: out of range.*40 to 2000"):
        configured(links={"mocap.rate": rate})


def test_a_continuous_joint_turns_once_and_a_prismatic_one_has_no_servo(tmp_path):
    lower, upper, rates = servo_limits(Vehicle(write_arm_of(tmp_path / "turning.urdf", 3, kinds={1: "continuous"})))
    np.testing.assert_allclose(lower, [-1.8, -math.pi, -1.8], atol=1e-12)
    np.testing.assert_allclose(upper, [1.8, math.pi, 1.8], atol=1e-12)
    np.testing.assert_array_equal(rates, [3.1] * 3)
    with pytest.raises(BackendError, match="prismatic") as caught:
        servo_limits(Vehicle(write_arm_of(tmp_path / "sliding.urdf", 3, kinds={1: "prismatic"})))
    assert caught.value.field == "joint eta_2"
