"""Calibrations write what the emulated servos, the emulated cameras and a made door really are."""

from __future__ import annotations

import json
import math
import socket

import numpy as np
import pytest
from command_line import assert_bad_input, run

from doorman.hardware.vehicle_file import VehicleFile
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.recording import Recorder
from doorman.rig.emulators.mocap.emulator import BodyPose, MocapEmulator, TrackerSetup
from doorman.rig.emulators.servos import ServoEmulator
from doorman.rig.emulators.servos.bus import LaggingJoints
from doorman.rig.emulators.servos.unit import READY, ServoSetup
from doorman.scenario import Scenario

ANGLES = (0.3, -0.4, 1.2)
ZEROS = (1900, 2100, 2222)
SIGNS = (1, -1, 1)


@pytest.fixture
def arm(tmp_path):
    setups = [
        ServoSetup(number, zero=zero, direction=sign)
        for number, zero, sign in zip((4, 5, 6), ZEROS, SIGNS, strict=True)
    ]
    with ServoEmulator(setups, LaggingJoints(np.array(ANGLES)), link=tmp_path / "arm"):
        yield tmp_path / "arm"


def write(tmp_path, text):
    path = tmp_path / "my.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_zeros_of_the_servos_are_measured(arm, tmp_path):
    path = write(tmp_path, f'[servos]  # arm\nport = "{arm}"\nids = [4, 5, 6]\ndirections = [1, -1, 1]\n')
    ran = run("vehicle", "zeros", path, "--posture", ",".join(map(str, ANGLES)), "--json")
    assert ran.exit_code == 0, ran.output
    assert json.loads(ran.stdout) == {"servos.zero_positions": list(ZEROS)}
    assert VehicleFile.load(path).values["servos.zero_positions"] == ZEROS
    assert "[servos]  # arm" in (tmp_path / "my.toml").read_text()


def test_a_posture_of_another_arm_changes_nothing(arm, tmp_path):
    path = write(tmp_path, f'[servos]\nport = "{arm}"\nids = [4, 5, 6]\n')
    assert_bad_input(run("vehicle", "zeros", path, "--posture", "0,0"), "my.toml", "--posture", "3 angles")
    assert_bad_input(run("vehicle", "zeros", path, "--posture", "0,x,0"), "--posture")
    assert "zero_positions" not in VehicleFile.load(path).values


def test_a_servo_whose_zero_is_shifted_is_refused(tmp_path):
    setup = ServoSetup(4, {**READY, "homing offset": 100})
    path = write(tmp_path, f'[servos]\nport = "{tmp_path / "arm"}"\nids = [4]\n')
    with ServoEmulator([setup], LaggingJoints(np.zeros(1)), link=tmp_path / "arm"):
        assert_bad_input(run("vehicle", "zeros", path, "--posture", "0"), "my.toml", "homing offset is 100")


@pytest.fixture
def port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def cameras(port, position, yaw, **mounting):
    pose = BodyPose(position, [math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw)])
    return MocapEmulator(lambda time: pose, TrackerSetup("hexa", **mounting), ("127.0.0.1", port))


def test_the_object_in_the_body_is_measured(tmp_path, port):
    """Of a vehicle that stands at a known place with a heading of its own, in the axes of cameras that stand askew."""
    mounting = {"object_position": (0.02, -0.01, 0.06), "object_attitude": (0.01, -0.02, 0.3)}
    axes = {"origin_position": (1.0, 0.5, 0.1), "origin_attitude": (0.0, 0.0, 0.7)}
    path = write(
        tmp_path,
        f'[mocap]\nconnection = "udp:{port}"\nobject_name = "hexa"\n'
        "origin_position = [1.0, 0.5, 0.1]\norigin_attitude = [0.0, 0.0, 0.7]\nobject_position = [9, 9, 9]\n",
    )
    with cameras(port, (0.4, 0.3, 0.2), 0.8, **mounting, **axes):
        ran = run("vehicle", "object", path, "--at", "0.4,0.3,0.2", "--yaw", "0.8")
    assert ran.exit_code == 0, ran.output
    values = VehicleFile.load(path).values
    np.testing.assert_allclose(values["mocap.object_position"], mounting["object_position"], atol=3e-5)
    np.testing.assert_allclose(values["mocap.object_attitude"], mounting["object_attitude"], atol=1e-4)


def test_an_object_that_moves_or_is_not_there_is_refused(tmp_path, port):
    path = write(tmp_path, f'[mocap]\nconnection = "udp:{port}"\nobject_name = "hexa"\n')

    def swings(time: float) -> BodyPose:
        return BodyPose((0.0, 0.1 * math.sin(3.0 * time), 1.0))

    with MocapEmulator(swings, TrackerSetup("hexa"), ("127.0.0.1", port)):
        assert_bad_input(run("vehicle", "object", path, "--at", "0,0,0"), "the object moves")
    nobody = write(tmp_path, '[mocap]\nconnection = "none"\n')
    assert_bad_input(run("vehicle", "object", nobody, "--at", "0,0,0"), "the vehicle has no cameras", "my.toml")


@pytest.mark.parametrize("task", ["paper", "push_left"])
def test_the_cameras_axes_are_found_from_two_points_of_the_door(task, tmp_path):
    from doorman.model import Model

    door = Model(Scenario.load(task)).door
    yaw, shift = -1.1, np.array([2.0, -0.7, 0.4])
    turn = rotation_body_to_world([0.0, 0.0, yaw])
    latch = door.hinge_position + door.width * door.leaf_direction(0.5 * math.pi)
    seen = [",".join(map(repr, (turn.T @ (point - shift)).tolist())) for point in (door.hinge_position, latch)]
    path = write(tmp_path, "")
    ran = run("vehicle", "origin", path, task, f"--hinge={seen[0]}", f"--latch={seen[1]}")
    assert ran.exit_code == 0, ran.output
    values = VehicleFile.load(path).values
    np.testing.assert_allclose(values["mocap.origin_position"], shift, atol=1e-5)
    np.testing.assert_allclose(values["mocap.origin_attitude"], [0.0, 0.0, yaw], atol=1e-5)


def test_points_of_another_door_are_refused(tmp_path):
    path = write(tmp_path, "")
    assert_bad_input(
        run("vehicle", "origin", path, "--hinge", "0,0,0", "--latch", "0,0.8,0"), "--latch", "0.800 m", "1.2 m"
    )


def flight(path, lag=None, hover=True):
    with Recorder(path, {}, keep=False) as recorder:
        if hover:
            recorder.write("hover", 0.0, {"thrust": 0.4321, "force": 28.9, "voltage": 15.1})
        if lag is not None:
            recorder.write("attitude_loop", 6.0, {"lag": [lag - 0.01, lag + 0.01], "dead_time": [0.06, 0.08]})
    return str(path)


def test_a_flight_s_thrust_and_lag_are_learned(tmp_path):
    path = write(tmp_path, "[pixhawk.thrust_curve]\nhover_thrust = 0.5\nhover_force = 29.0\nshape = 0.3\n")
    ran = run("vehicle", "learn", path, flight(tmp_path / "flight.mcap", 0.09))
    assert ran.exit_code == 0, ran.output
    values = VehicleFile.load(path).values
    assert (values["vehicle.attitude_lag"], values["vehicle.attitude_dead_time"]) == (0.09, 0.07)
    assert values["pixhawk.thrust_curve.hover_thrust"] == 0.4321
    assert values["pixhawk.thrust_curve.hover_force"] == 28.9
    assert values["pixhawk.thrust_curve.shape"] == 0.3 and "pixhawk.thrust_curve.hover_voltage" not in values


@pytest.mark.parametrize(
    ("before", "measured", "written"), [("", 0.4, 0.4), ("", 0.0, None), ("shape = 0.3\n", 0.0, 0.0)]
)
def test_a_flight_s_slope_and_delay_are_learned(tmp_path, before, measured, written):
    path = write(tmp_path, f"[pixhawk.thrust_curve]\nhover_thrust = 0.5\nhover_force = 29.0\n{before}")
    with Recorder(tmp_path / "flight.mcap", {}, keep=False) as recorder:
        recorder.write("hover", 0.0, {"thrust": 0.4, "force": 28.9, "voltage": 15.1, "shape": measured, "slope": 1.3})
        recorder.write("poses", 0.0, {"delay": 0.0121, "latency": 0.0171, "rate": 100.0})
    ran = run("vehicle", "learn", path, str(tmp_path / "flight.mcap"))
    assert ran.exit_code == 0, ran.output
    values = VehicleFile.load(path).values
    assert values["mocap.latency"] == 0.0171 and values.get("pixhawk.thrust_curve.shape") == written


def test_a_recording_that_measured_nothing_changes_nothing(tmp_path):
    path = write(tmp_path, "")
    with Recorder(tmp_path / "flight.mcap", {}, keep=False) as recorder:
        recorder.write("event", 0.0, {"source": "test", "message": "nothing"})
    assert_bad_input(run("vehicle", "learn", path, str(tmp_path / "flight.mcap")), "flight.mcap", "measured neither")
    assert (tmp_path / "my.toml").read_text() == ""
