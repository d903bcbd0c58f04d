"""Conversions against Pinocchio, against the emulator's own way back, and against the library's Euler angles."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from doorman.exceptions import DimensionError
from doorman.hardware.mocap.frames import Alignment, object_angles, object_quaternion
from doorman.hardware.mocap.packets import parse
from doorman.kinematics.quaternions import angle_between, to_attitude
from doorman.kinematics.rotations import quaternion_of
from doorman.rig.emulators.mocap.emulator import BodyPose, TrackerSetup, TrackerStream

angle = st.floats(-3.1, 3.1)
pitch = st.floats(-1.5, 1.5)
length = st.floats(-10.0, 10.0)
angles = st.tuples(angle, pitch, angle)
places = st.tuples(length, length, length)


def matrix(quaternion):
    w, x, y, z = quaternion
    return pin.Quaternion(w, x, y, z).matrix()


@given(angles)
def test_object_angles_are_turns_about_x_then_y_then_z(rotation):
    expected = (
        pin.utils.rotate("x", rotation[0]) @ pin.utils.rotate("y", rotation[1]) @ pin.utils.rotate("z", rotation[2])
    )
    assert matrix(object_quaternion(rotation)) == pytest.approx(expected, abs=1e-12)


def test_one_object_by_hand():
    alignment = Alignment((0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0))
    position, quaternion = alignment.body_pose((1000.0, -2000.0, 500.0), (0.0, 0.0, math.pi / 2))
    assert position == pytest.approx((1.0, -2.0, 0.5))
    assert to_attitude(quaternion) == pytest.approx((0.0, 0.0, math.pi / 2))
    _, quaternion = alignment.body_pose((0.0, 0.0, 0.0), (0.3, 0.2, 0.0))
    assert matrix(quaternion)[0, 2] == pytest.approx(math.sin(0.2)), "about the turned y axis"


@settings(max_examples=40)
@given(places, angles, places, angles, places, angles)
def test_offsets_are_those_of_rigid_bodies(origin, axes, offset, mounting, place, rotation):
    def motion(attitude, translation):
        return pin.SE3(pin.rpy.rpyToMatrix(*attitude), np.array(translation))

    seen = pin.SE3(matrix(object_quaternion(rotation)), np.array(place))
    expected = motion(axes, origin) * seen * motion(mounting, offset).inverse()
    position, quaternion = Alignment(origin, axes, offset, mounting).body_pose(
        tuple(1e3 * value for value in place), rotation
    )
    assert position == pytest.approx(expected.translation, abs=1e-9)
    assert matrix(quaternion) == pytest.approx(expected.rotation, abs=1e-9)


@settings(max_examples=40)
@given(places, angles, places, angles, places, angles)
def test_what_the_emulator_sees_is_where_the_body_is(origin, axes, offset, mounting, position, attitude):
    setup = TrackerSetup("quad", latency=0.0, position_noise=0.0, attitude_noise=0.0, origin_position=origin,
                         origin_attitude=axes, object_position=offset, object_attitude=mounting)  # fmt: skip
    stream = TrackerStream(lambda at: BodyPose(position, quaternion_of(attitude)), setup)
    stream.expose(0.0)
    (seen,) = parse(stream.take(0.0)[0]).objects
    found, quaternion = Alignment(origin, axes, offset, mounting).body_pose(seen.translation, seen.rotation)
    assert found == pytest.approx(position, abs=1e-6)
    assert angle_between(quaternion, quaternion_of(attitude)) < 1e-6


@given(angles)
def test_vicon_angles_and_back(rotation):
    assert object_angles(object_quaternion(rotation)) == pytest.approx(rotation, abs=1e-9)


def test_offsets_are_checked():
    with pytest.raises(DimensionError, match=r"mocap\.object_position"):
        Alignment((0, 0, 0), (0, 0, 0), (0, 0), (0, 0, 0))
